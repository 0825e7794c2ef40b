"""The tactile probe."""
