"""Runs as figures, as a film, as a page, and in MuJoCo's window."""
