"""The laws that users compare, on one experiment."""
