"""Which picture of a target to take next."""
