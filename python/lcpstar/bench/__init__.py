"""Benchmarks of lcpstar on your own machine: `lcpstar bench tradeoff`, `lcpstar bench call`. NumPy only."""
