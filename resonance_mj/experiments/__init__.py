"""What an experiment file says, read, validated and written."""
