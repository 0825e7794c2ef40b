"""Two calibrations compared: is this the same camera as last year."""
