"""Whether a law that learns from cycle to cycle will stay stable, predicted before it runs."""
