"""`python -m resonance_mj.cli`."""

import sys

from .main import main

sys.exit(main())
