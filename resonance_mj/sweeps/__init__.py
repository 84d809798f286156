"""Many experiments that differ in some of their keys, as one dataset."""
