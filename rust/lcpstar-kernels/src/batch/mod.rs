//! Many small problems: one per SIMD lane. Imports point one way: `io <- newton, lemke_lanes, minors, task <- lanes <- work`.

pub mod io;
mod lanes;
mod lemke_lanes;
mod minors;
mod newton;
pub mod task;
pub mod work;
