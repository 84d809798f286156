"""What the stability proof claims, checked on a run."""
