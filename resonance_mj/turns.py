"""Whose turn it is, of threads that share what is one for the whole process."""

import threading

compiling = threading.RLock()
"""Held while MuJoCo compiles a model, and while a callback in Python is installed, which it would
call and fail by."""
