"""The calibration FILE and its evidence beside it."""
