"""Files and numbers that nobody hands in on purpose, against every decoder and reader: `python -m fuzzing`."""
