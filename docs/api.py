"""API pages from the docstrings: `make api` writes docs/api/index.html and what it leads to.

python docs/api.py [FOLDER]
"""

import sys
from pathlib import Path

import pdoc

import resonance_mj
import resonance_mj.testing


def main(folder: Path) -> None:
    """Write the pages of what is public."""
    # Public names are imported when they are first used, which pdoc does not do.
    vars(resonance_mj).update({name: getattr(resonance_mj, name) for name in resonance_mj.__all__})
    pdoc.render.configure(docformat="google", show_source=False, footer_text="resonance_mj")
    pdoc.pdoc("resonance_mj", "resonance_mj.testing", output_directory=folder)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "api")
