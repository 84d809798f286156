"""How wide and how fine a figure is, and as what it is written."""

COLUMN, PAGE = 3.5, 7.16
"""Widths of a column and of a page with two columns in IEEE's journals [in]."""

NARROWEST, WIDEST = 3.0, 20.0
KINDS, FORMATS = ("svg", "png", "pdf"), ("svg", "png")
"""As what a figure can be written, and is if nothing else is asked for."""

DPI, DRAFT = 300.0, 170.0
"""Pixels per inch of a PNG, and of the one that each run leaves: in print, and on a screen."""

COARSEST, FINEST = 50, 1200
