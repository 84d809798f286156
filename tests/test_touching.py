"""Which bodies touch at home and along a motion."""

import mujoco
import numpy as np
import pytest

from resonance_mj.experiments.loading import for_robot
from resonance_mj.robots.robot import build
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
    moved = np.stack([x, 0 * x], axis=1)
    still = touching(model, moved[:50])
    assert still == []
    wall, bob = touching(model, moved)
    assert (wall.first, wall.second) == ("wall", "cart")
    assert wall.depth == pytest.approx(0.19)
    assert wall.share == pytest.approx(0.19, abs=0.011)
    assert (bob.first, bob.second, bob.share) == ("wall", "bob", pytest.approx(0.09, abs=0.011))
    both = touching(model, np.tile([0.0, -1.0], (4, 1)))
    assert both == [("world", "bob", pytest.approx(0.1), 1.0)]
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    assert touching(model, moved) == []


ARM = """<mujoco><worldbody>{world}<body name="base" pos="0 0 1"><geom size=".05"/>
<body name="cover"><geom size=".06"/></body>
<body name="l1"><joint name="j1" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 .3 0 0" size=".02"/>
<body name="l2" pos=".3 0 0"><joint name="j2" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 .3 0 0" size=".02"/><site name="tool" pos=".3 0 0"/>
</body></body></body></worldbody></mujoco>"""


def built(tmp_path, world="", base=True, **given):
    path = tmp_path / "arm.xml"
    text = ARM.format(world=world)
    path.write_text(text if base else text.replace('<geom size=".05"/>', "").replace(".06", ".001"))
    changes = {"robot.home": [0.0, 0.5]} | {f"robot.{key}": value for key, value in given.items()}
    robot = build(for_robot(str(path)).replace(changes))
    return robot, touching(robot.model, robot.qpos[None])


def test_neighbours_that_overlap_at_home_pass_and_are_said(tmp_path):
    robot, left = built(tmp_path)
    assert left == []
    (said,) = [note for note in robot.notes if "overlap at home" in note]
    assert "base and l1" in said
    assert "cover and l1" in said
    robot, left = built(tmp_path, world='<geom name="post" size=".07" pos="0 0 1"/>', base=False)
    assert left == []
    assert any("post and l1" in note for note in robot.notes if "overlap at home" in note)


@pytest.mark.parametrize(
    ("world", "words"),
    [
        ('<geom name="floor" type="plane" size="1 1 1" pos="0 0 .99"/>', "floor and l1"),
        ('<body name="box" pos=".5 0 .9"><geom size=".1"/></body>', "box and l2"),
        ('<body name="ball" pos=".5 0 .9"><freejoint/><geom size=".1"/></body>', "ball and l2"),
        ('<geom name="wall" type="box" size=".1 1 1" pos=".6 0 1"/>', "wall and l2"),
    ],
)
def test_what_else_is_in_contact_at_home_is_said_with_its_cure_and_stays_in_the_way(
    tmp_path, world, words
):
    robot, left = built(tmp_path, world)
    assert [f"{touch.first} and {touch.second}" for touch in left]
    (said,) = [note for note in robot.notes if note.startswith("in contact at home")]
    assert words in said
    assert "robot.contacts" in said
    robot, left = built(tmp_path, world, contacts=False)
    assert left == []
    assert not [note for note in robot.notes if "at home" in note and "contact" in note]
