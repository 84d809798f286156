"""A run, or several beside each other, become one page to read and to send."""
