//! Column sufficient matrices: `x_i (Ax)_i <= 0` for all i forces `x_i (Ax)_i = 0` for all i.
//!
//! For y = |x| and the signs S of x on its support, `B = (SAS)[alpha, alpha]` has `By <= 0`, `By != 0`. When all
//! smaller supports pass, every proper minor is nonnegative, and a nonsingular P0 block with positive determinant
//! cannot have such a y (its inverse is P0, hence semimonotone): only blocks with `det <= 0` need a look.

use super::budget::{Budget, Search};
use crate::cone::Cone;
use crate::elimination::determinant;
use crate::imatrix::{IMatrix, by_size, embed, indices};
use crate::int::{Int, make_primitive};

/// `x` with `x_i (Ax)_i <= 0` for all i, `< 0` for one; `None` if A is column sufficient.
///
/// # Errors
/// `Stopped` by the budget.
pub fn violation(a: &IMatrix, budget: &Budget<'_>) -> Search<Option<Vec<Int>>> {
    let n = a.rows();
    budget.begin((1u64 << n.min(63)) - 1);
    for mask in by_size(n) {
        budget.step()?;
        let alpha = indices(mask);
        let block = a.principal(&alpha);
        if determinant(&block).sign() > 0 {
            continue;
        }
        for signs in 0..1u64 << (alpha.len() - 1) {
            budget.poll()?;
            if let Some(x) = with_signs(&block, signs << 1, budget)? {
                return Ok(Some(embed(&x, &alpha, n)));
            }
        }
    }
    Ok(None)
}

/// A violation whose entry i is `<= 0` where `signs` has bit i and `>= 0` elsewhere.
///
/// The sum of the rays of `{y >= 0, By <= 0}` has the largest support and the most rows negative.
fn with_signs(block: &IMatrix, signs: u64, budget: &Budget<'_>) -> Search<Option<Vec<Int>>> {
    let k = block.rows();
    let negative = |i: usize| signs >> i & 1 == 1;
    let mut cone = Cone::orthant(k);
    for i in 0..k {
        cone.nonnegative(
            (0..k).map(|j| if negative(i) == negative(j) { -block.at(i, j) } else { block.at(i, j).clone() }).collect(),
        );
    }
    let mut x = vec![Int::ZERO; k];
    for ray in cone.rays_unless(|| budget.poll())? {
        for i in 0..k {
            x[i] = if negative(i) { &x[i] - &ray[i] } else { &x[i] + &ray[i] };
        }
    }
    make_primitive(&mut x);
    let image = block.times(&x);
    Ok((0..k).any(|i| x[i].sign() * image[i].sign() < 0).then_some(x))
}
