"""Runs in which something is zero, missing, long or strange, by name."""

from functools import cache
from pathlib import Path

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.experiments.loading import for_robot

PENDULUM = """<mujoco><worldbody><body><joint name="hinge" axis="0 1 0" damping="0.02"/>
<geom type="sphere" pos="0 0 -0.4" size="0.03" mass="1.2" contype="0" conaffinity="0"/>
<site name="tool" pos="0 0 -0.5"/></body></worldbody>
<keyframe><key name="home" qpos="0"/></keyframe></mujoco>"""
SLOWLY = {"duration": 8.0, "period": 4.0, "shape": "line", "size": (0.1, 0.0), "center": [0.0]}
STILL = {"duration": 3.0, "shape": "fourier", "offset": [-0.3, 0.0], "blend": 0}
TWO_CYCLES = {"motion.0.duration": 2.0, "motion.1.duration": 2.0}
LONG = "left_" + 39 * "very_" + "long"


def chain(joints):
    """An arm of so many joints in a plane, bent by 20 degrees at each."""
    open_, close = "", ""
    for j in range(joints):
        open_ += (
            f'<body pos="{0.1 if j else 0} 0 0"><joint name="joint{j + 1}" axis="0 -1 0" '
            'damping="0.1"/><geom type="capsule" fromto="0 0 0 0.1 0 0" size="0.01" mass="0.2" '
            'contype="0" conaffinity="0"/>'
        )
        close += "</body>"
    home = " ".join(["-0.35"] * joints)
    return (
        f'<mujoco><worldbody>{open_}<site name="tool" pos="0.1 0 0"/>{close}</worldbody>'
        f'<keyframe><key name="home" qpos="{home}"/></keyframe></mujoco>'
    )


@cache
def simulated(name, folder):
    """A run by its name; its robot's file, if it has one of its own, is put into a folder."""

    def paper(changes):
        return rmj.load("paper").replace(TWO_CYCLES | {"expect": {}} | changes)

    def robot(xml, changes):
        path = Path(folder) / f"{name.replace(' ', '-')}.xml"
        path.write_text(xml)
        return for_robot(str(path)).replace(changes)

    def renamed(joint):
        two_link = library.robots()["two_link.xml"].read_text()
        return paper({"robot.mjcf": robot(two_link.replace("joint1", joint), {}).robot.mjcf})

    made = {
        "no spring helps": lambda: robot(
            PENDULUM, {"task.coordinates": ["x"], "motion": [SLOWLY]}
        ),
        "no torque": lambda: paper({"simulation.gravity": [0, 0, 0], "motion": [STILL]}),
        "no motion": lambda: paper({"motion": [STILL]}),
        "one cycle": lambda: paper({"motion": [rmj.load("paper").motion[0].model_dump()]}).replace(
            {"motion.0.duration": 1.0}
        ),
        "twelve joints": lambda: robot(chain(12), {"motion.0.duration": 3.0}),
        "mathematics": lambda: renamed(r"$\bad$"),
        "markup": lambda: renamed("&lt;b&gt;&amp;amp;&lt;/b&gt;"),
        "long names": lambda: renamed(LONG).replace({"name": LONG}),
        "diverges at once": lambda: paper({"law.k_v": 1e9}),
    }
    return rmj.simulate(made[name]())
