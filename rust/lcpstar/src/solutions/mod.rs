//! The whole solution set SOL(q, A) as faces: polyhedra given by vertices and rays, in exact numbers.
//!
//! For an index set alpha the piece `{z >= 0, z_i = 0 outside alpha, w_alpha = 0, w >= 0}` is a face of
//! `{z >= 0, A z + q >= 0}`, and SOL is the union of the pieces. The vertices and extreme rays of all of them are
//! found together by double description on the cone `{(z, t) >= 0, A z + q t >= 0}`, one row at a time, dropping
//! every generator as soon as some `z_i w_i > 0`: no sum of generators with it solves the problem.
//! [De Schutter & De Moor, Math. Programming 71 (1995)] The maximal sets of mutually complementary generators are
//! the maximal faces.

mod faces;
mod generators;

use crate::control::Control;
use crate::error::{LcpError, Result};
use crate::problem::Lcp;
use crate::status::Termination;
pub use faces::Face;

/// Largest order: generators keep their zeros in 128-bit sets, one bit is for t.
pub const MAX_ORDER: usize = 127;

/// All maximal faces of SOL(q, A), ordered by `alpha`; empty when there is no solution. Exact and complete.
///
/// Exponential in the worst case. A random problem without special structure keeps a few thousand generators at
/// n = 16; structure (bimatrix games, many zeros) helps.
///
/// # Errors
/// `TooLarge` beyond [`MAX_ORDER`]. The inner result: why it was stopped early.
pub fn solutions(lcp: &Lcp, control: &Control<'_>) -> Result<std::result::Result<Vec<Face>, Termination>> {
    if lcp.n() > MAX_ORDER {
        return Err(LcpError::TooLarge { name: "solutions", n: lcp.n(), limit: MAX_ORDER });
    }
    Ok(generators::complementary_generators(lcp, control).map(|generators| faces::assemble(lcp.n(), generators)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::dyadic::RationalVec;
    use crate::exact::proof::check_solution;
    use num_bigint::BigInt;

    fn all(n: usize, a: &[f64], q: &[f64]) -> Vec<Face> {
        let lcp = Lcp::new(n, a.to_vec(), q.to_vec()).expect("valid");
        let faces = solutions(&lcp, &Control::default()).expect("small").expect("not stopped");
        for face in &faces {
            assert!(!face.vertices.is_empty());
            for v in &face.vertices {
                assert!(check_solution(lcp.view(), v));
                for r in &face.rays {
                    let moved = RationalVec {
                        numerators: (0..n)
                            .map(|j| &v.numerators[j] * &r.denominator + &r.numerators[j] * &v.denominator)
                            .collect(),
                        denominator: &v.denominator * &r.denominator,
                    };
                    assert!(check_solution(lcp.view(), &moved));
                }
            }
        }
        faces
    }

    #[test]
    fn the_paper_example_has_three_solutions() {
        let faces = all(3, &[0.0, 1.0, 1.0, 2.0, 0.0, 2.0, -2.0, -5.0, 0.0], &[-4.0, -7.0, 10.0]);
        let mut found: Vec<Vec<f64>> = faces.iter().map(|f| f.vertices[0].to_f64()).collect();
        found.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert_eq!(found, [vec![0.0, 2.0, 3.5], vec![15.0 / 14.0, 11.0 / 7.0, 17.0 / 7.0], vec![5.0, 0.0, 4.0]]);
        assert!(faces.iter().all(|f| f.vertices.len() == 1 && f.rays.is_empty()));
        let third = faces.iter().find(|f| f.alpha.len() == 3).expect("the printed one");
        assert_eq!(third.vertices[0].denominator, BigInt::from(14));
    }

    #[test]
    fn degenerate_sets_have_rays() {
        let orthant = all(3, &[0.0; 9], &[0.0; 3]);
        assert_eq!(orthant.len(), 1);
        assert_eq!((orthant[0].vertices.len(), orthant[0].rays.len(), orthant[0].alpha.len()), (1, 3, 3));
        let segment = all(2, &[1.0, 1.0, 1.0, 1.0], &[-1.0, -1.0]);
        assert_eq!((segment.len(), segment[0].vertices.len(), segment[0].rays.len()), (1, 2, 0));
        assert_eq!(segment[0].alpha, [0, 1]);
    }

    #[test]
    fn no_solution_no_face_and_the_empty_problem() {
        assert!(all(1, &[-1.0], &[-1.0]).is_empty());
        assert!(all(1, &[0.0], &[-1.0]).is_empty());
        assert_eq!(all(0, &[], &[]).len(), 1);
        // q > 0: zero, and the other end of the interval for a negative entry.
        assert_eq!(all(1, &[-1.0], &[1.0]).len(), 2);
    }

    /// All 2^n basic points of nondegenerate integer problems, by exact proof.
    #[test]
    fn vertices_agree_with_all_bases() {
        use crate::exact::proof::{ProofOutcome, prove_solution};
        let mut rng = fastrand::Rng::with_seed(99);
        let mut draw = |m: u32| f64::from(rng.u32(..m));
        for trial in 0..120 {
            let n = 2 + trial % 4;
            let span = [7, 1000][trial % 2];
            let a: Vec<f64> = (0..n * n).map(|_| draw(span) - f64::from(span / 2)).collect();
            let q: Vec<f64> = (0..n).map(|_| draw(span) - f64::from(span / 2)).collect();
            let lcp = Lcp::new(n, a.clone(), q.clone()).expect("valid");
            let faces = all(n, &a, &q);
            let inside = |z: &RationalVec| {
                faces.iter().any(|f| {
                    f.vertices
                        .iter()
                        .any(|v| (0..n).all(|j| &v.numerators[j] * &z.denominator == &z.numerators[j] * &v.denominator))
                })
            };
            let mut expected = 0;
            for mask in 0..1usize << n {
                let alpha: Vec<usize> = (0..n).filter(|i| mask >> i & 1 == 1).collect();
                let block = crate::exact::padic::Block::new(alpha.len(), |i, j| lcp.row(alpha[i])[alpha[j]], &|| false);
                if let (Ok(_), ProofOutcome::Proved(s)) = (block, prove_solution(lcp.view(), &alpha, &|| false)) {
                    assert!(inside(&s.z), "n = {n}, alpha = {alpha:?}");
                    expected += 1;
                }
            }
            if span == 1000 {
                assert_eq!(faces.len(), expected);
            }
        }
    }
}
