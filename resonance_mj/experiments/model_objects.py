"""A MuJoCo model from memory as a file, so that an experiment can name it, save it and be sent."""

import hashlib
import tempfile
from pathlib import Path
from typing import Any

FOLDER = "models"
"""Folder of such files in the user's cache."""


def as_file(given: Any) -> Any:
    """The path of a file that holds an MjSpec or MjModel, the same for the same model.

    Anything else is returned as it is.

    Raises:
        ValueError: MuJoCo cannot compile the MjSpec.
    """
    if not type(given).__module__.startswith("mujoco"):
        return given
    import mujoco
    import numpy as np
    from platformdirs import user_cache_path

    model = given.compile() if isinstance(given, mujoco.MjSpec) else given
    if not isinstance(model, mujoco.MjModel):
        return given
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    content = buffer.tobytes()
    name = model.names.partition(b"\0")[0].decode(errors="replace")
    safe = "".join(letter for letter in name if letter.isalnum() or letter in "-_") or "model"
    folder = user_cache_path("resonance-mj") / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{safe[:60]}-{hashlib.sha256(content).hexdigest()[:8]}.mjb"
    if not path.is_file() or path.read_bytes() != content:
        with tempfile.NamedTemporaryFile(dir=folder, delete=False) as file:
            file.write(content)
        Path(file.name).replace(path)
    return str(path)
