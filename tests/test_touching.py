"""Which bodies touch at home and along a motion."""

import mujoco
import numpy as np
import pytest

from resonance_mj.robots.touching import touching

SLIDER = """<mujoco><worldbody>
<geom name="wall" type="box" size=".1 1 1" pos="1.1 0 0"/>
<geom type="plane" size="1 1 1" pos="0 0 -2"/>
<body name="cart"><joint name="x" type="slide" axis="1 0 0"/><geom size=".2"/>
<body name="bob" pos="0 0 -1"><joint name="z" type="slide" axis="0 0 1"/><geom size=".1"/>
</body></body>
</worldbody></mujoco>"""


def test_bodies_that_touch_along_a_motion_are_told_with_their_depth_and_their_share_of_it():
    model = mujoco.MjModel.from_xml_string(SLIDER)
    x = np.linspace(0, 0.99, 100)
    still = touching(model, model.qpos0, np.array([0]), x[:50, None])
    assert still == []
    wall, bob = touching(model, model.qpos0, np.array([0]), x[:, None])
    assert (wall.first, wall.second) == ("wall", "cart")
    assert wall.depth == pytest.approx(0.19)
    assert wall.share == pytest.approx(0.19, abs=0.011)
    assert (bob.first, bob.second, bob.share) == ("wall", "bob", pytest.approx(0.09, abs=0.011))
    both = touching(model, np.array([0.0, -1.0]), np.array([0]), np.zeros((4, 1)))
    assert both == [("world", "bob", pytest.approx(0.1), 1.0)]
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    assert touching(model, model.qpos0, np.array([0]), x[:, None]) == []
