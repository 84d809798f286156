"""`python -m resonance_mj.cli`."""

import sys

from .entry import main

sys.exit(main())
