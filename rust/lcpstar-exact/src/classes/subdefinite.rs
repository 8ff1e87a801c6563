//! Positive subdefinite (PSBD) and pseudomonotone matrices.

use super::budget::{Budget, Search};
use super::definite::negative_direction;
use crate::cone::Cone;
use crate::elimination::{reduce, reduce_unless};
use crate::imatrix::{IMatrix, complement, indices};
use crate::int::{Int, dot, make_primitive};

/// `x` with `x'Ax < 0` where `A'x` has a positive and a negative entry; `None` if A is PSBD. Polynomial: O(n^5).
///
/// For columns `a_i, a_j` of A the form must be nonnegative on the wedge `a_i x >= 0 >= a_j x`.
///
/// # Errors
/// `Stopped` by the budget.
pub fn subdefinite_violation(a: &IMatrix, budget: &Budget<'_>) -> Search<Option<Vec<Int>>> {
    let s = a.symmetric_part();
    let Some(direction) = negative_direction(&s, false, budget)? else { return Ok(None) };
    let n = a.rows();
    let column = |j: usize| (0..n).map(|i| a.at(i, j).clone()).collect::<Vec<_>>();
    for i in 0..n {
        for j in (0..n).filter(|&j| j != i) {
            if let Some(mut x) = wedge_violation(&s, &column(i), &column(j), &direction, budget)? {
                make_primitive(&mut x);
                return Ok(Some(x));
            }
        }
    }
    Ok(None)
}

/// `x` with `c x > 0 > d x` and `x'Sx < 0`, given some `direction` where the form is negative.
fn wedge_violation(
    s: &IMatrix,
    c: &[Int],
    d: &[Int],
    direction: &[Int],
    budget: &Budget<'_>,
) -> Search<Option<Vec<Int>>> {
    let n = c.len();
    let rows = IMatrix::new(2, n, [c, d].concat());
    let reduced = reduce(rows, n);
    Ok(match reduced.pivots() {
        &[a, b] => {
            // p: c p > 0, d p = 0;  q: c q = 0, d q < 0.
            let delta = Int::cross(&c[a], &d[b], &c[b], &d[a], &Int::ONE).sign();
            let signed = |x: &Int, s: i32| if s * delta > 0 { x.clone() } else { -x };
            let mut p = vec![Int::ZERO; n];
            (p[a], p[b]) = (signed(&d[b], 1), signed(&d[a], -1));
            let mut q = vec![Int::ZERO; n];
            (q[a], q[b]) = (signed(&c[b], 1), signed(&c[a], -1));
            quadrant_violation(s, p, q, &reduced.null_space(n), budget)?
        }
        [_] if (dot(c, d)).sign() < 0 => {
            // Opposite columns: the wedge is a half space, and x or -x is in it.
            let x: Vec<Int> = direction.to_vec();
            let value = dot(c, &x).sign();
            Some(match value {
                0 => push(s, &x, c),
                1 => x,
                _ => x.iter().map(|v| -v).collect(),
            })
        }
        _ => None,
    })
}

/// `u p + v q + W y` with `u, v > 0` where the form is negative.
fn quadrant_violation(
    s: &IMatrix,
    p: Vec<Int>,
    q: Vec<Int>,
    w: &[Vec<Int>],
    budget: &Budget<'_>,
) -> Search<Option<Vec<Int>>> {
    let k = w.len();
    let base = add(&p, &q);
    let mut entries = Vec::with_capacity(k * (k + 2));
    for x in w {
        budget.poll_each()?;
        entries.extend(w.iter().map(|y| s.form(x, y)).chain([-&s.form(x, &p), -&s.form(x, &q)]));
    }
    let on_w = IMatrix::new(k, k + 2, entries);
    let square = on_w.block(&(0..k).collect::<Vec<_>>(), &(0..k).collect::<Vec<_>>());
    if let Some(y) = negative_direction(&square, false, budget)? {
        return Ok(Some(push(s, &combine(w, &y), &base)));
    }
    let reduced = reduce_unless(on_w, k, || budget.poll())?;
    for y in reduced.null_space(k) {
        // The form is linear along the kernel direction x: if it moves at all, it goes to minus infinity.
        let x = combine(w, &y);
        let (along_p, along_q) = (s.form(&x, &p), s.form(&x, &q));
        if along_p.is_zero() && along_q.is_zero() {
            continue;
        }
        let start = if (&along_p + &along_q).is_zero() { add(&base, &q) } else { base };
        let x = if s.form(&x, &start).sign() > 0 { x.iter().map(|v| -v).collect() } else { x };
        return Ok(Some(push(s, &x, &start)));
    }
    // Schur complement: move p and q by the minimisers over W, then a 2 x 2 form must be copositive.
    let (Some((yp, tp)), Some((yq, tq))) = (reduced.particular(k, k), reduced.particular(k, k + 1)) else {
        return Ok(None);
    };
    let p = add(&scale(&p, &tp), &combine_or_zero(w, &yp, s.rows()));
    let q = add(&scale(&q, &tq), &combine_or_zero(w, &yq, s.rows()));
    let (alpha, beta, delta) = (s.form(&p, &p), s.form(&p, &q), s.form(&q, &q));
    Ok(if alpha.sign() < 0 {
        Some(push(s, &p, &q))
    } else if delta.sign() < 0 {
        Some(push(s, &q, &p))
    } else if beta.sign() >= 0 || Int::cross(&beta, &beta, &alpha, &delta, &Int::ONE).sign() <= 0 {
        None
    } else if alpha.is_zero() {
        Some(push(s, &p, &q))
    } else {
        Some(add(&scale(&p, &-&beta), &scale(&q, &alpha)))
    })
}

/// `t x + y` for the first power of two t that makes the form negative; the form goes to minus infinity along x.
fn push(s: &IMatrix, x: &[Int], y: &[Int]) -> Vec<Int> {
    let mut t = Int::ONE;
    loop {
        let point = add(&scale(x, &t), y);
        if s.form(&point, &point).sign() < 0 {
            return point;
        }
        t = &t + &t;
    }
}

fn add(x: &[Int], y: &[Int]) -> Vec<Int> {
    x.iter().zip(y).map(|(a, b)| a + b).collect()
}

fn scale(x: &[Int], t: &Int) -> Vec<Int> {
    x.iter().map(|a| a * t).collect()
}

fn combine(w: &[Vec<Int>], y: &[Int]) -> Vec<Int> {
    combine_or_zero(w, y, w.first().map_or(0, Vec::len))
}

fn combine_or_zero(w: &[Vec<Int>], y: &[Int], n: usize) -> Vec<Int> {
    w.iter().zip(y).fold(vec![Int::ZERO; n], |sum, (b, t)| add(&sum, &scale(b, t)))
}

/// `(x, y)`, both nonnegative, with `(y - x)'Ax >= 0 > (y - x)'Ay`; `None` if A is pseudomonotone on the orthant.
///
/// With z = y - x and c = A'z the pair exists if and only if `c x >= 0 > c (x + z)` for some `x >= max(0, -z)`. When c
/// has both signs this asks for `z'Az < 0` only (not PSBD); `c >= 0` is impossible; for `c <= 0` it means
/// `c_i = 0` where `z_i < 0` and `z'Az < 0`: one cone per set of negative entries, and the sum of its rays decides.
///
/// # Errors
/// `Stopped` by the budget.
pub fn pseudomonotone_violation(a: &IMatrix, budget: &Budget<'_>) -> Search<Option<(Vec<Int>, Vec<Int>)>> {
    let n = a.rows();
    let negative_part = |z: &[Int]| z.iter().map(|v| if v.sign() < 0 { -v } else { Int::ZERO }).collect::<Vec<_>>();
    if let Some(z) = subdefinite_violation(a, budget)? {
        // Reach c x = 0, or just above c (x + z): push x along an entry of c with the sign that is needed.
        let c = a.transpose_times(&z);
        let x = negative_part(&z);
        let value = dot(&c, &x);
        let i = (0..n).find(|&i| c[i].sign() * value.sign() < 0);
        let (mut x, scale_by) = (x, i.map_or(Int::ONE, |i| c[i].abs()));
        x = scale(&x, &scale_by);
        if let Some(i) = i {
            x[i] = &x[i] + &value.abs();
        }
        let y = add(&x, &scale(&z, &scale_by));
        return Ok(Some((x, y)));
    }
    for beta in 0..1u64 << n {
        budget.poll()?;
        let mut cone = Cone::new(n);
        for i in 0..n {
            let negative = beta >> i & 1 == 1;
            cone.nonnegative(
                (0..n).map(|j| Int::from(if i == j { if negative { -1 } else { 1 } } else { 0 })).collect(),
            );
        }
        let column = |i: usize| (0..n).map(|r| a.at(r, i).clone()).collect::<Vec<_>>();
        indices(beta).into_iter().for_each(|i| cone.zero(column(i)));
        for i in indices(complement(beta, n)) {
            cone.nonnegative(column(i).iter().map(|v| -v).collect());
        }
        let z = cone.rays_unless(|| budget.poll())?.iter().fold(vec![Int::ZERO; n], |sum, ray| add(&sum, ray));
        if a.form(&z, &z).sign() < 0 {
            let x = negative_part(&z);
            let y = add(&x, &z);
            return Ok(Some((x, y)));
        }
    }
    Ok(None)
}
