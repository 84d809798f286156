"""Runs held against what their experiments expect."""
