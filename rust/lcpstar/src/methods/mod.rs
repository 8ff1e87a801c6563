//! One file per method. A method takes a problem, its settings and a [`Control`](crate::Control), and returns a
//! [`Candidate`](crate::Candidate). It does not judge its own answer and imports no other method.

pub mod admm;
pub mod apgd;
pub mod bilinear;
pub mod block_pivoting;
pub mod chandrasekaran;
pub mod enumerate;
pub mod feasibility;
pub mod interior_point;
pub mod lemke;
pub mod lemke_howson;
pub mod newton;
pub mod nncg;
pub mod pgs;
pub mod pgs_sm;
pub mod potential_reduction;
pub mod principal_pivoting;
