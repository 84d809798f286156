"""All that is known of an experiment before its first step."""
