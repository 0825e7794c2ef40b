"""The entrance pupil, from pictures of two pins."""
