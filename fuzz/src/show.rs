//! What a file of the corpus stands for, printed on request.

/// `LCPSTAR_FUZZ_SHOW=1 target/release/lcpstar-fuzz FILE` prints the problem and the options that FILE stands for.
static SHOW: std::sync::LazyLock<bool> = std::sync::LazyLock::new(|| std::env::var_os("LCPSTAR_FUZZ_SHOW").is_some());

/// Prints it, if asked for.
pub fn show(what: &dyn std::fmt::Debug) {
    if *SHOW {
        eprintln!("{what:?}");
    }
}
