"""Photographs of concentric rings."""
