"""A laser and its camera, from its line on flats at known ranges or in gauges of known diameter."""
