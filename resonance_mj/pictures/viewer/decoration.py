"""Overlays as decoration of the window's scene, which casts no shadow on the arm."""

import mujoco
import numpy as np

from ..film.surroundings import PREFIX


class Decoration:
    """Takes the overlays out of the model and puts them into the scene that is added to it.

    The vertices of a skin without colour go on following the model, and a geom of the type skin
    shows them.

    Args:
        model: with overlays as skins.
        scene: the viewer's scene for its user's geoms.
    """

    def __init__(self, model: mujoco.MjModel, scene: mujoco.MjvScene) -> None:
        self._model, self._scene = model, scene
        skins = [s for s in range(model.nskin) if model.skin(s).name.startswith(PREFIX)]
        self._skins = [(s, scene.geoms[at]) for at, s in enumerate(skins)]
        for skin, geom in self._skins:
            none = np.zeros(3)
            shape = mujoco.mjtGeom.mjGEOM_SKIN
            mujoco.mjv_initGeom(geom, shape, none, none, np.eye(3).ravel(), np.ones(4, np.float32))
            geom.objtype, geom.objid, geom.dataid = int(mujoco.mjtObj.mjOBJ_SKIN), skin, skin
            geom.category = int(mujoco.mjtCatBit.mjCAT_DECOR)
            material = int(model.skin_matid[skin])
            geom.emission = model.mat_emission[material]
            geom.specular = model.mat_specular[material]
        scene.ngeom = len(self._skins)

    def update(self) -> None:
        """Show the overlays as the model has them now."""
        for skin, geom in self._skins:
            geom.rgba[:] = self._model.skin_rgba[skin]
            self._model.skin_rgba[skin, 3] = 0.0
