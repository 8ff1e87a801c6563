//! Secondary rays in the caller's units.

use crate::scaling::{Scaling, times_power_of_two};
use crate::solution::Ray;

/// The ray of the equilibrated problem, if doubles hold it in the caller's units with all its digits.
pub(super) fn to_caller(scaling: &Scaling, scaled: &Ray) -> Option<Ray> {
    let s = times_power_of_two;
    let ray = Ray {
        z: scaling.z_to_caller(&scaled.z),
        z0: s(scaled.z0, -scaling.q),
        z_hat: scaling.direction_to_caller(&scaled.z_hat),
        z0_hat: scaled.z0_hat,
        w_hat: scaled.w_hat.iter().zip(&scaling.rows).map(|(&w, &r)| s(w, -r)).collect(),
        d: scaled.d.iter().zip(&scaling.rows).map(|(&d, &r)| s(d, -r)).collect(),
    };
    let pairs = [(&ray.z, &scaled.z), (&ray.z_hat, &scaled.z_hat), (&ray.w_hat, &scaled.w_hat), (&ray.d, &scaled.d)];
    let vectors = pairs.into_iter().flat_map(|(x, y)| x.iter().zip(y));
    let numbers = [(&ray.z0, &scaled.z0), (&ray.z0_hat, &scaled.z0_hat)];
    let is_held = vectors.chain(numbers).all(|(x, y)| x.is_normal() || *y == 0.0);
    is_held.then_some(ray)
}
