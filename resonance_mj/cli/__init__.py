"""The command line: the only place that prints or exits."""

from .entry import main

__all__ = ["main"]
