//! One problem, its proof, and one that has no solution: `cargo run --example solve`.
#![allow(clippy::print_stdout)]

use lcpstar::prelude::*;
use lcpstar::{Certify, Method};

fn main() -> lcpstar::Result<()> {
    let (a, q) = ([2.0, 1.0, 1.0, 2.0], [-5.0, -6.0]);
    let found = solve(&a, &q, &Options::default())?;
    println!(
        "{:?} by {}: z = {:?}, residual {:.1e}",
        found.status(),
        found.method().as_str(),
        found.z(),
        found.residual()
    );

    let options = Options::default().method(Method::from_name("lemke")?).certify(Certify::Exact);
    if let Some(Certificate::Solution { exact: Some(z), .. }) = solve(&a, &q, &options)?.certificate() {
        println!("proved: z = {:?} / {}", z.numerators, z.denominator);
    }

    let found = solve(&[1.0, -1.0, -1.0, 1.0], &[-1.0, -1.0], &Options::default())?;
    if let Some(Certificate::Infeasible { y }) = found.certificate() {
        println!("infeasible: y = {:?} has y >= 0, A'y <= 0, q'y < 0", y.to_f64());
    }
    Ok(())
}
