"""Benchmarks: ratios against named peers in the same run, with spread and a truth check. `python -m benchmarks`."""
