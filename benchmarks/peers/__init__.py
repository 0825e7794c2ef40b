"""What others would write: short, reviewed, as good as a careful user makes it."""
