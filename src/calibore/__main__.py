"""`python -m calibore` is the `calibore` command."""

from calibore.cli import main

main()
