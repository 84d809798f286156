"""A run becomes a video."""
