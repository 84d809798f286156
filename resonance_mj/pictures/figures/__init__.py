"""Figures of runs, certificates and comparisons."""
