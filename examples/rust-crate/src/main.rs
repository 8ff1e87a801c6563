use lcpstar::prelude::*;

fn main() -> lcpstar::Result<()> {
    let (a, options) = ([2.0, 1.0, 1.0, 2.0], Options::default());
    println!("{:?}", lcpstar::solve(&a, &[-5.0, -6.0], &options)?.z());
    println!("{:?}", lcpstar::solve_batch(&a, &[-5.0, -6.0, 1.0, -4.0], 2, &options)?.z(1));
    println!("{:?}", lcpstar::is_in_class(&a, 2, "P", None)?);
    Ok(())
}
