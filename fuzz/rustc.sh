#!/bin/sh
# The RUSTC_WRAPPER of `make fuzz`: the coverage counters that libFuzzer reads, in the crates `lcpstar` and
# `lcpstar-*` that it is made of. Stable
# compiler flags; what it calls (faer, big integers) would only blur the signal.
case " $* " in
*" --crate-name lcpstar "* | *" --crate-name lcpstar_linalg "* | *" --crate-name lcpstar_kernels "* | *" --crate-name lcpstar_exact "*)
  exec "$@" -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
    -Cllvm-args=-sanitizer-coverage-trace-compares
  ;;
*) exec "$@" ;;
esac
