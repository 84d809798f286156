"""A run and its figures: what simulation gives and everything else reads."""
