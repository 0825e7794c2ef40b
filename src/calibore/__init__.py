"""Calibore measures the inside of pipes with laser light, and says how well.

Start at the command line (`calibore demo`) or with `calibore.profiling.profile_scan`. Importing this package imports
nothing else: each sub-package is imported when it is first used.
"""

__version__ = "0.1.0"
