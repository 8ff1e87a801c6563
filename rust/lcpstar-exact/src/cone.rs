//! Extreme rays of a pointed polyhedral cone `{x : E x = 0, G x >= 0}` by double description.

use super::elimination::reduce;
use super::imatrix::IMatrix;
use super::int::{Int, dot, make_primitive};
use std::convert::Infallible;

/// Rows of equations `E` and inequalities `G` in `dimension` unknowns.
#[derive(Clone, Debug)]
pub struct Cone {
    dimension: usize,
    equations: Vec<Vec<Int>>,
    inequalities: Vec<Vec<Int>>,
}

impl Cone {
    /// The whole space.
    #[must_use]
    pub fn new(dimension: usize) -> Self {
        Self { dimension, equations: Vec::new(), inequalities: Vec::new() }
    }

    /// The nonnegative orthant.
    #[must_use]
    pub fn orthant(dimension: usize) -> Self {
        let unit = |i: usize| (0..dimension).map(|j| Int::from(i64::from(i == j))).collect();
        Self { dimension, equations: Vec::new(), inequalities: (0..dimension).map(unit).collect() }
    }

    /// Adds `row x = 0`.
    pub fn zero(&mut self, row: Vec<Int>) {
        debug_assert_eq!(row.len(), self.dimension);
        self.equations.push(row);
    }

    /// Adds `row x >= 0`.
    pub fn nonnegative(&mut self, row: Vec<Int>) {
        debug_assert_eq!(row.len(), self.dimension);
        self.inequalities.push(row);
    }

    /// The extreme rays as primitive integer vectors. The cone must be pointed (no line), at most 128 inequalities.
    #[must_use]
    pub fn rays(&self) -> Vec<Vec<Int>> {
        let Ok(rays) = self.rays_unless::<Infallible>(|| Ok(()));
        rays
    }

    /// As [`rays`](Self::rays), with a question before each ray that is looked at: there may be exponentially many.
    ///
    /// # Errors
    /// What `stopped` says.
    pub fn rays_unless<E>(&self, stopped: impl Fn() -> Result<(), E>) -> Result<Vec<Vec<Int>>, E> {
        let basis = self.basis();
        let inequalities: Vec<Vec<Int>> =
            self.inequalities.iter().map(|g| basis.iter().map(|b| dot(g, b)).collect()).collect();
        let rays = rays_in_coordinates(&inequalities, basis.len(), stopped)?;
        Ok(rays
            .into_iter()
            .map(|u| {
                let mut x: Vec<Int> = vec![Int::ZERO; self.dimension];
                for (coefficient, b) in u.iter().zip(&basis) {
                    for (entry, value) in x.iter_mut().zip(b) {
                        *entry = &*entry + &(coefficient * value);
                    }
                }
                make_primitive(&mut x);
                x
            })
            .collect())
    }

    /// A basis of the solutions of the equations.
    fn basis(&self) -> Vec<Vec<Int>> {
        let rows = self.equations.concat();
        reduce(IMatrix::new(self.equations.len(), self.dimension, rows), self.dimension).null_space(self.dimension)
    }
}

/// A ray of the current cone and the set of inequalities that hold with equality there.
struct Ray {
    x: Vec<Int>,
    tight: u128,
}

/// Double description in `k` coordinates without equations.
fn rays_in_coordinates<E>(
    inequalities: &[Vec<Int>],
    k: usize,
    stopped: impl Fn() -> Result<(), E>,
) -> Result<Vec<Vec<Int>>, E> {
    debug_assert!(inequalities.len() <= 128);
    match k {
        0 => return Ok(Vec::new()),
        1 => {
            let fits = |sign: i32| inequalities.iter().all(|g| g[0].sign() * sign >= 0);
            return Ok([1, -1].into_iter().filter(|&s| fits(s)).map(|s| vec![Int::from(i64::from(s))]).collect());
        }
        _ => {}
    }
    let Some((start, mut rays)) = simplicial_start(inequalities, k) else {
        return Ok(Vec::new());
    };
    let mut added = start.iter().fold(0u128, |mask, &i| mask | 1 << i);
    for (index, g) in inequalities.iter().enumerate() {
        if added & (1 << index) == 0 {
            rays = cut(rays, g, index, k, &stopped)?;
            added |= 1 << index;
        }
    }
    Ok(rays.into_iter().map(|ray| ray.x).collect())
}

/// `k` independent inequalities and the rays of their simplicial cone.
fn simplicial_start(inequalities: &[Vec<Int>], k: usize) -> Option<(Vec<usize>, Vec<Ray>)> {
    let columns = IMatrix::from_fn(k, inequalities.len(), |i, j| inequalities[j][i].clone());
    let start = reduce(columns, inequalities.len()).pivots().to_vec();
    if start.len() < k {
        debug_assert!(false, "the cone contains a line");
        return None;
    }
    let all = start.iter().fold(0u128, |mask, &i| mask | 1 << i);
    let system = IMatrix::from_fn(k, 2 * k, |i, j| {
        if j < k { inequalities[start[i]][j].clone() } else { Int::from(i64::from(i == j - k)) }
    });
    let reduced = reduce(system, k);
    let rays = (0..k)
        .filter_map(|j| {
            let (mut x, _) = reduced.particular(k, k + j)?;
            make_primitive(&mut x);
            Some(Ray { x, tight: all & !(1 << start[j]) })
        })
        .collect();
    Some((start, rays))
}

/// Intersects the cone with `g x >= 0`.
fn cut<E>(
    rays: Vec<Ray>,
    g: &[Int],
    index: usize,
    k: usize,
    stopped: &impl Fn() -> Result<(), E>,
) -> Result<Vec<Ray>, E> {
    let values: Vec<Int> = rays.iter().map(|ray| dot(g, &ray.x)).collect();
    let mut kept = Vec::new();
    for (p, ray) in rays.iter().enumerate() {
        if values[p].sign() <= 0 {
            continue;
        }
        stopped()?;
        for (m, other) in rays.iter().enumerate() {
            if values[m].sign() < 0 && adjacent(&rays, p, m, k) {
                let mut x: Vec<Int> =
                    (0..k).map(|i| Int::cross(&values[p], &other.x[i], &values[m], &ray.x[i], &Int::ONE)).collect();
                make_primitive(&mut x);
                kept.push(Ray { x, tight: (ray.tight & other.tight) | 1 << index });
            }
        }
    }
    for (mut ray, value) in rays.into_iter().zip(values) {
        if value.sign() >= 0 {
            if value.is_zero() {
                ray.tight |= 1 << index;
            }
            kept.push(ray);
        }
    }
    Ok(kept)
}

/// Two extreme rays span a face exactly when no third one is tight wherever both are.
fn adjacent(rays: &[Ray], p: usize, m: usize, k: usize) -> bool {
    let common = rays[p].tight & rays[m].tight;
    common.count_ones() as usize + 2 >= k
        && rays.iter().enumerate().all(|(i, ray)| i == p || i == m || common & !ray.tight != 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ints(x: &[i64]) -> Vec<Int> {
        x.iter().map(|&v| v.into()).collect()
    }

    #[test]
    fn square_cone_has_four_rays() {
        let mut cone = Cone::orthant(3);
        cone.nonnegative(ints(&[-1, 0, 1]));
        cone.nonnegative(ints(&[0, -1, 1]));
        let mut rays = cone.rays();
        rays.sort();
        assert_eq!(rays, [[0, 0, 1], [0, 1, 1], [1, 0, 1], [1, 1, 1]].map(|r| ints(&r)).to_vec());
    }

    #[test]
    fn equations_lower_the_dimension() {
        let mut cone = Cone::orthant(4);
        cone.zero(ints(&[1, 1, -1, -1]));
        assert_eq!(cone.rays().len(), 4);
        cone.zero(ints(&[1, 1, 1, 1]));
        assert!(cone.rays().is_empty());
    }

    /// Rows that repeat or follow from others leave the rays alone.
    #[test]
    fn redundant_rows_do_no_harm() {
        let mut cone = Cone::orthant(2);
        for _ in 0..3 {
            cone.nonnegative(ints(&[1, 1]));
            cone.nonnegative(ints(&[2, -1]));
        }
        let mut rays = cone.rays();
        rays.sort();
        assert_eq!(rays, vec![ints(&[1, 0]), ints(&[1, 2])]);
    }
}
