//! Maximal faces: maximal sets of mutually complementary generators that hold a vertex.

use super::generators::Finished;
use crate::exact::dyadic::RationalVec;

/// A maximal face of SOL(q, A): the convex hull of `vertices` plus the cone of `rays`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Face {
    /// `{i : z_i > 0 for some z of the face}`; `w_i = 0` on the whole face for these i.
    pub alpha: Vec<usize>,
    /// At least one.
    pub vertices: Vec<RationalVec>,
    /// Directions with largest entry 1.
    pub rays: Vec<RationalVec>,
}

/// Sorts generators into maximal faces.
pub(super) fn assemble(n: usize, generators: Vec<Finished>) -> Vec<Face> {
    let pairs = if n == 0 { 0 } else { u128::MAX >> (128 - n) };
    let meets = |g: &Finished, h: &Finished| (g.z_support & h.w_support | h.z_support & g.w_support) & pairs == 0;
    let neighbours: Vec<Vec<usize>> = (0..generators.len())
        .map(|k| (0..generators.len()).filter(|&l| l != k && meets(&generators[k], &generators[l])).collect())
        .collect();
    let mut cliques = Vec::new();
    extend(&neighbours, &mut Vec::new(), (0..generators.len()).collect(), Vec::new(), &mut cliques);
    let is_vertex = |k: &usize| generators[*k].z_support >> n & 1 == 1;
    let mut faces: Vec<Face> = cliques
        .into_iter()
        .filter(|clique| clique.iter().any(is_vertex))
        .map(|clique| {
            let support = clique.iter().fold(0, |s, &k| s | generators[k].z_support) & pairs;
            let (vertices, rays): (Vec<usize>, Vec<usize>) = clique.into_iter().partition(is_vertex);
            Face {
                alpha: (0..n).filter(|&i| support >> i & 1 == 1).collect(),
                vertices: vertices.into_iter().map(|k| vertex(n, &generators[k].exact)).collect(),
                rays: rays.into_iter().map(|k| ray(n, &generators[k].exact)).collect(),
            }
        })
        .collect();
    for face in &mut faces {
        face.vertices.sort_by(by_value);
        face.rays.sort_by(by_value);
    }
    faces.sort_by(|f, g| f.alpha.cmp(&g.alpha));
    faces
}

/// Bron and Kerbosch with the pivot of most neighbours: maximal cliques.
fn extend(
    neighbours: &[Vec<usize>],
    clique: &mut Vec<usize>,
    mut candidates: Vec<usize>,
    mut done: Vec<usize>,
    out: &mut Vec<Vec<usize>>,
) {
    let Some(&pivot) = candidates
        .iter()
        .chain(&done)
        .max_by_key(|&&k| candidates.iter().filter(|c| neighbours[k].binary_search(c).is_ok()).count())
    else {
        out.push(clique.clone());
        return;
    };
    let branch: Vec<usize> =
        candidates.iter().copied().filter(|c| neighbours[pivot].binary_search(c).is_err()).collect();
    for k in branch {
        let near = |set: &[usize]| -> Vec<usize> {
            set.iter().copied().filter(|l| neighbours[k].binary_search(l).is_ok()).collect()
        };
        clique.push(k);
        extend(neighbours, clique, near(&candidates), near(&done), out);
        clique.pop();
        candidates.retain(|&c| c != k);
        done.push(k);
    }
}

fn vertex(n: usize, v: &RationalVec) -> RationalVec {
    let mut out = RationalVec { numerators: v.numerators[..n].to_vec(), denominator: v.numerators[n].clone() };
    out.reduce();
    out
}

fn ray(n: usize, v: &RationalVec) -> RationalVec {
    let mut out = RationalVec { numerators: v.numerators[..n].to_vec(), denominator: v.denominator.clone() };
    out.reduce();
    out
}

fn by_value(a: &RationalVec, b: &RationalVec) -> std::cmp::Ordering {
    let ordered = a.numerators.iter().zip(&b.numerators).map(|(x, y)| (x * &b.denominator).cmp(&(y * &a.denominator)));
    ordered.into_iter().find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
}
