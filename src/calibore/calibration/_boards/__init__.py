"""Chessboards, ChArUco boards and grids of dots: pictures of a plane of known points."""
