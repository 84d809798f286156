"""`resonance-mj` and `python -m resonance_mj.cli`: a process that ends with its command."""

import gc
import sys
from typing import NoReturn

from .entry import main


def script() -> NoReturn:
    """Run the command line and end the process with its exit status."""
    status = main()
    # The process ends: to look for garbage first would take a third of a second.
    gc.freeze()
    sys.exit(status)


if __name__ == "__main__":
    script()
