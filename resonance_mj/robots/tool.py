"""The point of an arm that works: the one that is named, or the one that is found."""

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from ..errors import RobotError
from ..text import Note, listed, shown
from . import arms, chain
from .names import UNNAMED, is_sensor, usual

CENTER = "com:"
"""Begins the name of a tool that is the center of mass of the body named behind it."""

ON_AXIS = 1e-6
"""How much nearer to all axes than the center of mass an origin is that no joint moves."""


@dataclass(frozen=True)
class Tool:
    """What follows the motion, or could: it hangs on the last joint of the arm.

    Attributes:
        name: in the file.
        kind: site, body or center of mass.
        body: the body that carries it; the body itself.
        point: where it is in that body (3,) [m]; of a site as the file has it.
    """

    name: str
    kind: str
    body: str
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)


def find_tools(
    model: mujoco.MjModel, given: str | None, arm: str | None, path: Path, notes: list[str]
) -> tuple[Tool, ...]:
    """What could be the tool, first what is, then what else hangs on the ends of arms.

    Args:
        model: of the file.
        given: name of a site or body, or com: and a body's; None to find it.
        arm: a word that says which of several arms is meant.
        path: of the file.
        notes: get lines of what was found.

    Raises:
        RobotError: there is no such tool or arm, or none at all.
    """
    branches = arms.find(model)
    if arm is not None:
        branches = arms.choose(branches, arm, path)
    sites = [model.site(i) for i in range(model.nsite)]
    tools = [Tool(site.name, "site", model.body(int(site.bodyid[0])).name) for site in sites]
    tools += [Tool(model.body(i).name, "body", model.body(i).name) for i in range(1, model.nbody)]
    at_ends = [
        tool
        for branch in branches
        for tool in tools
        if tool.name and model.body(tool.body).id in branch.ends
    ]
    if given is None:
        chosen = _found(model, branches, at_ends, path, notes)
        worth = [one for one in branches if one is branches[0] or len(one.names) > 1]
        if len(worth) > 1:
            notes.append(
                Note(
                    f"arms: {arms.described(worth)}; the first is taken",
                    ", robot.arm or robot.tool takes another",
                )
            )
    else:
        named = [tool for tool in tools if tool.name == given]
        bodies = [tool for tool in tools if CENTER + tool.name == given and tool.kind == "body"]
        named += [_center(model, model.body(tool.name).id) for tool in bodies]
        if not named:
            raise RobotError(
                f"{path}: robot.tool = {shown(given)}: no such site or body; its sites are: "
                f"{_names(tools, 'site')}; its bodies: {_names(tools, 'body')}"
            )
        chosen = named[0]
    others = [tool for tool in at_ends if tool != chosen and not tool.name.startswith(UNNAMED)]
    return (chosen, *dict.fromkeys(others))


def _found(
    model: mujoco.MjModel,
    branches: list[arms.Branch],
    at_ends: list[Tool],
    path: Path,
    notes: list[str],
) -> Tool:
    """The first arm's tool by its usual name, else a site, else the deepest body."""
    if not branches:
        for j in range(model.njnt):
            if chain.carries_spring(model, j):
                chain.check(model, chain.joints_to(model, int(model.jnt_bodyid[j])), path)
        raise RobotError(
            f"{path}: no hinge or slide joint moves anything in it; an arm needs at least one"
        )
    own = [tool for tool in at_ends if model.body(tool.body).id in branches[0].ends]
    own = [tool for tool in own if not is_sensor(tool.name)] or own
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    end = data.xanchor[branches[0].joints[-1]]

    def away(tool: Tool) -> float:
        place = data.site(tool.name) if tool.kind == "site" else data.body(tool.name)
        return float(np.linalg.norm(place.xpos - end))

    for kind in ("site", "body"):
        ranked = {tool: usual(tool.name) for tool in own if tool.kind == kind}
        likely = [(place, -away(tool), tool) for tool, place in ranked.items() if place is not None]
        if likely:
            tool = min(likely, key=lambda one: one[:2])[2]
            notes.append(f"tool: {kind} {tool.name!r}, found by its usual name")
            return tool
    sites = [tool for tool in own if tool.kind == "site"]
    if sites:
        named = [tool for tool in sites if not tool.name.startswith(UNNAMED)]
        best = max(named or sites, key=away)
        why = "the only one" if len(sites) == 1 else "the farthest out"
        notes.append(f"tool: site {best.name!r}, {why} on the arm's end")
        return best
    best = max(
        own,
        key=lambda tool: (
            not tool.name.startswith(UNNAMED),
            chain.depth(model, model.body(tool.name).id),
        ),
    )
    notes.append(f"tool: body {best.name!r}, the deepest of the longest chain of joints")
    return best


def _center(model: mujoco.MjModel, body: int) -> Tool:
    """The center of mass of a body as a tool."""
    name = model.body(body).name
    x, y, z = model.body_ipos[body].tolist()
    return Tool(CENTER + name, "center of mass", name, (x, y, z))


def moved(
    model: mujoco.MjModel, tools: tuple[Tool, ...], joints: list[int], notes: list[str]
) -> tuple[Tool, ...]:
    """The tools that were found, the first at its center of mass if no joint moves its origin.

    Args:
        model: of the file.
        tools: as from `find_tools`.
        joints: ids of those that move.
        notes: get a line of the change.
    """
    name = tools[0].name
    if (
        tools[0].kind != "body"
        or (model.jnt_type[joints] != int(mujoco.mjtJoint.mjJNT_HINGE)).any()
    ):
        return tools
    data, body = mujoco.MjData(model), model.body(name).id
    mujoco.mj_kinematics(model, data)
    anchors, axes = data.xanchor[joints], data.xaxis[joints]
    origin, center = (
        np.linalg.norm(np.cross(axes, at - anchors), axis=1).max()
        for at in (data.xpos[body], data.xipos[body])
    )
    if origin >= ON_AXIS * center:
        return tools
    notes.append(f"tool: the center of mass of body {name!r}, whose origin no joint moves")
    return (_center(model, body), *tools[1:])


def _names(tools: list[Tool], kind: str) -> str:
    return listed(tool.name for tool in tools if tool.kind == kind)
