"""`python -m resonance_mj` is `resonance-mj`."""

from .cli.__main__ import script

script()
