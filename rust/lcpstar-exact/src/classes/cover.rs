//! Does a family of cones cover a simplicial cone? The exact test behind Q, Q0 and the (++)-property.
//!
//! A simplicial cone is split along an edge where the facet of a family cone cuts it, until each part lies in one
//! member of the family or its centre lies in none. The tree of splits is a proof that can be checked by hand.

use super::budget::{Budget, Search};
use crate::int::{Int, dot, make_primitive};

/// A closed cone `{x : f x >= 0 for all facets f}` and the name it has in the proof.
#[derive(Clone, Debug)]
pub struct Member {
    /// Its name.
    pub label: usize,
    /// Inward normals.
    pub facets: Vec<Vec<Int>>,
}

/// A step of the proof, in the order of a depth-first walk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// Put `ray`, which lies between generators `a` and `b`, in the place of `a` first and of `b` second.
    Split {
        /// First generator.
        a: usize,
        /// Second generator.
        b: usize,
        /// The new generator.
        ray: Vec<Int>,
    },
    /// All generators lie in this member.
    Inside(usize),
}

/// The outcome.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Covering {
    /// Every part lies in a member.
    Covered(Vec<Step>),
    /// A point in the interior that no member contains.
    Hole(Vec<Int>),
}

/// A generator with the sign of every facet of the family at it.
#[derive(Clone)]
struct Generator {
    x: Vec<Int>,
    signs: Vec<Vec<i32>>,
}

/// The family and the question whether a point off all members is a hole.
pub struct Family<'a> {
    members: &'a [Member],
    is_hole: &'a dyn Fn(&[Int]) -> bool,
}

impl<'a> Family<'a> {
    /// `is_hole` must fail on a set without interior only: degenerate members that are not in the family.
    #[must_use]
    pub fn new(members: &'a [Member], is_hole: &'a dyn Fn(&[Int]) -> bool) -> Self {
        Self { members, is_hole }
    }

    /// Covers the cone of the given independent generators.
    ///
    /// # Errors
    /// `Stopped` by the budget.
    pub fn cover(&self, generators: Vec<Vec<Int>>, budget: &Budget<'_>) -> Search<Covering> {
        let mut steps = Vec::new();
        let start: Vec<Generator> = generators.into_iter().map(|x| self.generator(x)).collect();
        let mut stack = vec![(start, None)];
        while let Some((part, pending)) = stack.pop() {
            budget.poll_each()?;
            // A facet is worked off before another one is chosen: a part on one side of it stays there, so it ends.
            let pending = pending.filter(|&facet| cut_edge(&part, facet).is_some());
            if pending.is_none()
                && let Some(member) = (0..self.members.len()).find(|&m| part.iter().all(|g| inside(&g.signs[m])))
            {
                steps.push(Step::Inside(self.members[member].label));
                continue;
            }
            let facet = match pending.map_or_else(|| self.choose(&part), Ok) {
                Ok(facet) => facet,
                Err(hole) => return Ok(Covering::Hole(hole)),
            };
            let (a, b) = cut_edge(&part, facet).expect("invariant: the chosen facet cuts an edge");
            let ray = self.crossing(&part[a], &part[b], facet);
            steps.push(Step::Split { a, b, ray: ray.x.clone() });
            for place in [b, a] {
                let mut child = part.clone();
                child[place] = ray.clone();
                stack.push((child, Some(facet)));
            }
        }
        Ok(Covering::Covered(steps))
    }

    fn generator(&self, x: Vec<Int>) -> Generator {
        let signs = self.members.iter().map(|m| m.facets.iter().map(|f| dot(f, &x).sign()).collect()).collect();
        Generator { x, signs }
    }

    /// A facet that cuts a part which no member contains, or a hole in it.
    fn choose(&self, part: &[Generator]) -> Result<(usize, usize), Vec<Int>> {
        let mut attempt = 0;
        loop {
            let centre = centre(part, attempt);
            let containing = (0..self.members.len())
                .filter(|&m| self.members[m].facets.iter().all(|f| dot(f, &centre).sign() >= 0))
                .max_by_key(|&m| part.iter().filter(|g| inside(&g.signs[m])).count());
            // The centre is a positive sum of the generators, in m, and some generator is not: a facet cuts an edge.
            let facet = containing.and_then(|m| {
                (0..self.members[m].facets.len()).map(|f| (m, f)).find(|&facet| cut_edge(part, facet).is_some())
            });
            if let Some(facet) = facet {
                return Ok(facet);
            }
            if (self.is_hole)(&centre) {
                return Err(centre);
            }
            attempt += 1;
        }
    }

    /// The point of the edge where the facet vanishes.
    fn crossing(&self, a: &Generator, b: &Generator, (m, f): (usize, usize)) -> Generator {
        let facet = &self.members[m].facets[f];
        let (above, below) = (dot(facet, &a.x), dot(facet, &b.x));
        let mut x: Vec<Int> = a.x.iter().zip(&b.x).map(|(p, q)| Int::cross(&above, q, &below, p, &Int::ONE)).collect();
        make_primitive(&mut x);
        self.generator(x)
    }
}

/// A generator above and one below facet f of member m.
fn cut_edge(part: &[Generator], (m, f): (usize, usize)) -> Option<(usize, usize)> {
    let at = |s: i32| part.iter().position(|g| g.signs[m][f] == s);
    at(1).zip(at(-1))
}

fn inside(signs: &[i32]) -> bool {
    signs.iter().all(|&s| s >= 0)
}

/// A positive combination of the generators; the weights change with the attempt and leave every hyperplane.
fn centre(part: &[Generator], attempt: u32) -> Vec<Int> {
    let mut x = vec![Int::ZERO; part[0].x.len()];
    for (i, g) in part.iter().enumerate() {
        let weight = Int::from(1 + i64::from(attempt).pow(i as u32 + 1) * i64::from(attempt.min(1)));
        for (entry, value) in x.iter_mut().zip(&g.x) {
            *entry = &*entry + &(&weight * value);
        }
    }
    make_primitive(&mut x);
    x
}

#[cfg(test)]
mod tests {
    use super::super::budget::Stopped;
    use super::*;
    use std::time::Instant;

    /// A part may take milliseconds: the clock is asked before the first one already.
    #[test]
    fn the_clock_is_asked_for_every_part() {
        let unit = |i: i64| vec![Int::from(1 - i), Int::from(i)];
        let members = [Member { label: 7, facets: vec![unit(0), unit(1)] }];
        let family = Family::new(&members, &|_| true);
        let orthant = || vec![unit(0), unit(1)];
        let late = Budget::new(Some(Instant::now()), None);
        assert!(matches!(family.cover(orthant(), &late), Err(Stopped::TimeLimit)));
        let covering = family.cover(orthant(), &Budget::unlimited());
        assert!(matches!(covering, Ok(Covering::Covered(steps)) if steps == [Step::Inside(7)]));
    }
}
