"""Motions: closed forms, derivatives against differences, frames, rotation, CSV, passages."""

import subprocess
import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import resonance_mj as rmj
from resonance_mj.errors import ResonanceError
from resonance_mj.experiments.motion_section import Motion
from resonance_mj.motions import default_motion, motion, rotations
from resonance_mj.motions.kinematics import Kinematics
from resonance_mj.motions.motion import resolve, sample
from resonance_mj.motions.passing import blended, by_a_small_motion
from resonance_mj.plan.plan import plan_for
from resonance_mj.robots.reach import reach
from resonance_mj.robots.robot import build

SIX_JOINTS = """
<mujoco>
  <compiler angle="radian"/>
  <default><geom contype="0" conaffinity="0"/></default>
  <worldbody>
    <body name="base" pos="0.1 -0.2 0.3" euler="0.2 -0.3 0.7">
      <geom size="0.05"/>
      <body pos="0 0 0.2"><joint axis="0 0 1"/><geom size="0.05"/>
        <body pos="0 0 0.1"><joint axis="0 1 0" range="-3 3" limited="true"/><geom size="0.05"/>
          <body pos="0.4 0 0"><joint axis="0 1 0" range="-3 3" limited="true"/><geom size="0.05"/>
            <body pos="0.3 0 0"><joint axis="1 0 0"/><geom size="0.04"/>
              <body pos="0.05 0 0"><joint axis="0 1 0"/><geom size="0.04"/>
                <body pos="0.05 0 0"><joint axis="1 0 0"/><geom size="0.03"/>
                  <site name="tool" pos="0.1 0 0.02" euler="0.5 0.4 -0.3"/>
  </body></body></body></body></body></body></body></worldbody>
  <keyframe><key name="home" qpos="0.3 -0.9 1.6 0.4 0.6 0.2"/></keyframe>
</mujoco>
"""
STEPS = 400
SHAPES = {
    "ellipse": {"size": (0.06, 0.03)},
    "line": {"shape": "line", "size": (0.06, 0.03)},
    "eight": {"shape": "eight", "size": (0.06, 0.03)},
    "triangle": {"shape": "polygon", "corners": 3, "size": (0.06, 0.03), "rounding": 0.3},
    "round polygon": {"shape": "polygon", "corners": 5, "size": (0.06, 0.06), "rounding": 1.0},
    "points": {"shape": "points", "points": ((0.3, 0.1), (0.36, 0.1), (0.33, 0.13)),
               "rests": (0.1, 0.0, 0.1), "moves": (0.25, 0.15, 0.2)},
    "fourier": {"shape": "fourier", "offset": (0.3, 0.1), "sin": ((0.05,), (0.0, 0.02)),
                "cos": ((0.0, 0.01), (0.03,))},
    "csv": {"shape": "csv"},
}  # fmt: skip
TURN = {"rotation_sin": ((0.5,), (0.0, 0.3), (0.2,)), "rotation_cos": ((0.1,), (0.7,), (0.0,))}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("motion")
    (path / "six.xml").write_text(SIX_JOINTS)
    angle = 2 * np.pi * np.arange(12) / 12
    points = np.stack([np.cos(angle), np.sin(angle), np.sin(2 * angle)], 1) * 0.05
    np.savetxt(path / "xz.csv", points[:, :2], delimiter=",")
    np.savetxt(path / "xyz.csv", points, delimiter=",", header="x,y,z", comments="")
    return path


def arm(folder, *coordinates, mjcf=None):
    """An experiment's robot with these task coordinates."""
    if not coordinates:
        return build(rmj.load("paper"))
    listed = ", ".join(f'"{name}"' for name in coordinates)
    mjcf = mjcf or folder / "six.xml"
    path = folder / "task.toml"
    path.write_text(f'[robot]\nmjcf = "{mjcf}"\n[task]\ncoordinates = [{listed}]\n')
    return build(rmj.load(path))


@pytest.fixture(scope="module")
def planar(folder):
    return arm(folder)


@pytest.fixture(scope="module")
def spatial(folder):
    return arm(folder, "x", "y", "z")


@pytest.fixture(scope="module")
def turning(folder):
    return arm(folder, "x", "y", "z", "rotation")


def filled(robot, **keys):
    at_home = Kinematics(robot).position(robot.home)
    return resolve(Motion(**{"period": 0.8, "duration": 8.0, **keys}), robot, at_home)


def fitting(keys, robot, folder):
    """A shape's keys with as many coordinates as the robot's task has."""
    keys = dict(keys)
    if keys.get("shape") == "csv":
        keys["file"] = str(folder / ("xz.csv" if len(robot.position_axes) == 2 else "xyz.csv"))
    if "points" in keys:
        keys["points"] = tuple((*row, 0.02)[: len(robot.position_axes)] for row in keys["points"])
    if "offset" in keys:
        more = robot.m - 2
        keys["offset"] += (0.02,) * more
        keys["sin"] += ((0.01, 0.02),) * more
        keys["cos"] += ((0.0, 0.1),) * more
    return keys


def rate(values, period):
    """Time derivative of a periodic signal, by central differences of second order."""
    return (np.roll(values, -1, 0) - np.roll(values, 1, 0)) * len(values) / (2 * period)


def order(robot, keys):
    """Largest errors of dx and ddx against differences, at a step and at half of it."""
    one, errors = filled(robot, **keys), []
    for steps in (STEPS, 2 * STEPS):
        x, dx, ddx, _ = sample(one, steps, robot)
        errors.append([
            np.abs(rate(x, one.period) - dx).max() / np.abs(dx).max(),
            np.abs(rate(dx, one.period) - ddx).max() / np.abs(ddx).max(),
        ])  # fmt: skip
    return np.array(errors)


@pytest.mark.parametrize("shape", SHAPES)
def test_velocity_and_acceleration_are_the_derivatives_over_the_seam_too(shape, planar, folder):
    errors = order(planar, fitting(SHAPES[shape], planar, folder))
    assert errors.max() < (0.06 if shape == "points" else 0.02)  # whose third derivative jumps
    # Central differences are of second order, where the third derivative is continuous; a cubic
    # spline's is not.
    assert (errors[1] < 0.6 * errors[0]).all()
    assert errors[1, 0] < 0.3 * errors[0, 0]


@pytest.mark.parametrize("frame", ["world", "base", "tool"])
@pytest.mark.parametrize("shape", SHAPES)
def test_derivatives_hold_in_every_frame(shape, frame, spatial, folder):
    keys = fitting(SHAPES[shape], spatial, folder)
    errors = order(spatial, {**keys, "frame": frame})
    assert (errors[1] < 0.6 * errors[0]).all()


@pytest.mark.parametrize("shape", SHAPES)
def test_position_velocity_and_acceleration_are_continuous(shape, planar, folder):
    one = filled(planar, **fitting(SHAPES[shape], planar, folder))
    largest = {}
    for steps in (2000, 4000):
        for name, values in zip(("x", "dx", "ddx"), sample(one, steps, planar)[:3], strict=True):
            jump = np.abs(np.roll(values, -1, 0) - values).max() / np.ptp(values, 0).max()
            largest.setdefault(name, []).append(jump)
    for coarse, fine in largest.values():
        assert fine < 0.55 * coarse  # A jump would stay as large.


def test_an_ellipse_an_eight_and_a_line_have_their_closed_forms(planar):
    angle = 2 * np.pi * np.arange(STEPS) / STEPS
    a, b, center = 0.06, 0.03, np.array([-0.3, 0.05])
    for shape, expected in (
        ("ellipse", (a * np.cos(angle), b * np.sin(angle))),
        ("eight", (a * np.sin(angle), b * np.sin(2 * angle))),
        ("line", (a * np.sin(angle), b * np.sin(angle))),
    ):
        one = filled(planar, shape=shape, size=(a, b), center=tuple(center))
        x = sample(one, STEPS, planar).x
        assert np.allclose(x, center + np.stack(expected, 1), atol=1e-15)


def test_point_to_point_rests_where_it_should_and_moves_on_straight_lines_with_minimum_jerk(planar):
    one = Motion(
        shape="points",
        points=((0.3, 0.1), (0.4, 0.2), (0.3, 0.2)),
        rests=(0.2, 0.1, 0.0),
        period=2.0,
    )
    found = sample(one, 2000, planar)
    time, move = np.arange(2000) / 1000, (2.0 - 0.3) / 3
    resting = (time < 0.2) | ((time > 0.2 + move) & (time < 0.3 + move))
    assert (found.dx[resting] == 0).all()
    assert (found.ddx[resting] == 0).all()
    np.testing.assert_array_equal(found.x[time < 0.2], np.tile([0.3, 0.1], (200, 1)))
    r = (time - 0.2) / move
    first = (r > 0) & (r < 1)
    share = 10 * r**3 - 15 * r**4 + 6 * r**5
    np.testing.assert_allclose(found.x[first, 0], 0.3 + 0.1 * share[first], atol=1e-12)
    np.testing.assert_allclose(found.x[first, 1], 0.1 + 0.1 * share[first], atol=1e-12)
    assert np.abs(found.dx[:, 0]).max() == pytest.approx(1.875 * 0.1 / move, rel=1e-3)
    last = time > 0.3 + 2 * move
    np.testing.assert_allclose(found.x[last, 0], 0.3)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"points": ((0.3, 0.1),)}, "two or more rows"),
        ({"points": ((0.3, 0.1), (0.3,))}, "of 1, 2 numbers"),
        ({"points": ((0.3, 0.1), (0.4, 0.1)), "rests": (0.5, 0.6)}, "no time to move"),
        ({"points": ((0.3, 0.1), (0.4, 0.1)), "rests": (0.1, 0.1, 0.1)}, "3 rests and 0 moves"),
        ({"points": ((0.3, 0.1), (0.4, 0.1)), "moves": (0.5, 0.4)}, "take 0.9 s together"),
        ({"points": ((0.3, 0.1), (0.4, 0.1)), "moves": (1.0, 0.0)}, "a time above 0 s"),
        ({"points": ((0.3, 0.1), (0.4, 0.1)), "size": (0.1, 0.1)}, "not size"),
    ],
)
def test_points_that_do_not_fit_are_refused_with_what_would(keys, words):
    with pytest.raises(ResonanceError, match=words):
        rmj.load("two-link-transfer").replace({"motion": [{"shape": "points", **keys}]})


def test_points_of_another_width_than_the_task_are_refused_by_name():
    points = [[0.3, 0.1, 0.2], [0.4, 0.1, 0.2]]
    experiment = rmj.load("two-link-transfer").replace(
        {"motion": [{"shape": "points", "points": points}]}
    )
    with pytest.raises(ResonanceError, match=r"points have 3 numbers each.*x, z"):
        plan_for(experiment)


@pytest.mark.parametrize("corners", [3, 4, 7])
def test_a_polygon_follows_its_sides_and_stays_within_them(corners, planar):
    rounding, radius = 0.4, 0.1
    one = filled(planar, shape="polygon", corners=corners, rounding=rounding,
                 size=(radius, radius), center=(0.0, 0.0))  # fmt: skip
    x, _, ddx, _ = sample(one, 100 * corners, planar)
    normal = 2 * np.pi * (np.arange(corners) + 0.5) / corners
    from_side = radius * np.cos(np.pi / corners) - x @ np.stack([np.cos(normal), np.sin(normal)])
    assert from_side.min() > -1e-15
    straight = np.abs(from_side).min(axis=1) < 1e-15
    assert np.isclose(straight.mean(), 1 - rounding, atol=0.02)
    assert np.abs(ddx[straight]).max() < 1e-9
    # Each corner is as the first, turned.
    turn = Rotation.from_euler("z", 2 * np.pi / corners).as_matrix()[:2, :2]
    assert np.allclose(np.roll(x, -100, 0), x @ turn.T, atol=1e-15)


def test_less_rounding_comes_nearer_to_the_corner(planar):
    def nearest(rounding):
        one = filled(planar, shape="polygon", size=(0.1, 0.1), center=(0, 0), rounding=rounding)
        return 0.1 - sample(one, STEPS, planar).x[0, 0]

    assert np.isclose(nearest(0.5), 0.5 * nearest(1.0), rtol=1e-12)
    assert nearest(1e-3) < 1e-4


def test_a_base_or_tool_frame_is_a_rigid_displacement(spatial, folder):
    keys = fitting(SHAPES["csv"], spatial, folder)
    inside = sample(filled(spatial, **keys), STEPS, spatial)
    base = Rotation.from_euler("XYZ", [0.2, -0.3, 0.7]).as_matrix()  # MuJoCo's intrinsic xyz
    for frame, at, turn in (
        ("base", np.array([0.1, -0.2, 0.3]), base),
        ("tool", Kinematics(spatial).position(spatial.home), spatial.orientation),
    ):
        found = sample(filled(spatial, frame=frame, **keys), STEPS, spatial)
        assert np.allclose(found.x, at + inside.x @ turn.T, atol=1e-12)
        assert np.allclose(found.dx, inside.dx @ turn.T, atol=1e-12)
        assert np.allclose(found.ddx, inside.ddx @ turn.T, atol=1e-10)


@pytest.mark.parametrize("frame", ["world", "base", "tool"])
def test_without_a_center_the_middle_is_where_the_tool_is_at_home(frame, spatial):
    one = filled(spatial, frame=frame, size=(0.05, 0.02))
    middle = sample(one, STEPS, spatial).x.mean(axis=0)
    assert np.allclose(middle, Kinematics(spatial).position(spatial.home), atol=1e-12)
    assert frame != "tool" or np.allclose(one.center, 0.0, atol=1e-15)


def test_a_frame_that_turns_within_the_tasks_plane_is_allowed(planar):
    one = filled(planar, frame="tool", size=(0.05, 0.0), shape="line")
    x = sample(one, STEPS, planar).x
    along = planar.orientation[[0, 2], 0]
    away = x - x.mean(axis=0)
    assert np.allclose(away, np.outer(away @ along, along), atol=1e-15)


def orientations(samples, robot):
    return Rotation.from_rotvec(samples.x[:, -3:]) * Rotation.from_matrix(robot.orientation)


@pytest.mark.parametrize("shape", SHAPES)
def test_rates_of_rotation_are_the_angular_velocity_and_acceleration(shape, turning, folder):
    one = filled(turning, **{**fitting(SHAPES[shape], turning, folder), **TURN})
    steps = 4000
    samples = sample(one, steps, turning)
    assert np.linalg.norm(samples.x[:, -3:], axis=1).max() > 0.8
    R, dt = orientations(samples, turning), one.period / steps
    index = np.arange(steps)
    step = R[(index + 1) % steps] * R[(index - 1) % steps].inv()
    omega = step.as_rotvec() / (2 * dt)
    scale = np.abs(samples.dx[:, -3:]).max()
    assert np.abs(omega - samples.dx[:, -3:]).max() < 1e-5 * scale
    alpha = rate(samples.dx[:, -3:], one.period)
    assert np.abs(alpha - samples.ddx[:, -3:]).max() < 1e-5 * np.abs(alpha).max()
    # The distinction matters: the rotation vector's own derivative is another.
    assert np.abs(rate(samples.x[:, -3:], one.period) - omega).max() > 0.02 * scale


def test_joints_that_follow_a_rotation_move_at_the_velocity_that_it_says(turning):
    keys = {"rotation_sin": ((0.1,), (0.0, 0.1), (0.1,)), "rotation_cos": ((), (0.1,), ())}
    one = filled(turning, size=(0.03, 0.02), **keys)
    found = Kinematics(turning).follow(
        sample(one, STEPS, turning), turning.home, one.period, "motion"
    )
    assert np.abs(rate(found.q, one.period) - found.dq).max() < 2e-3 * np.abs(found.dq).max()
    assert np.abs(rate(found.dq, one.period) - found.ddq).max() < 2e-3 * np.abs(found.ddq).max()


def test_angular_rates_go_there_and_back_and_are_plain_about_a_fixed_axis():
    rng = np.random.default_rng(0)
    r, dr, ddr = rng.normal(size=(3, 50, 3))
    r *= rng.uniform(0, 3.1, (50, 1)) / np.linalg.norm(r, axis=1, keepdims=True)
    r[0] = 0.0
    back = rotations.to_rates(r, *rotations.from_rates(r, dr, ddr))
    assert np.allclose(back[0], dr, atol=1e-11)
    assert np.allclose(back[1], ddr, atol=1e-10)
    omega, alpha = rotations.from_rates(r, 2 * r, 3 * r)
    assert np.allclose(omega, 2 * r)
    assert np.allclose(alpha, 3 * r)


@pytest.mark.parametrize("name", ["planar", "turning"])
@pytest.mark.parametrize("cycles", [1, 3])
def test_a_passage_leaves_and_arrives_smoothly(name, cycles, request, folder):
    robot = request.getfixturevalue(name)
    turn = TURN if robot.rotates else {}
    old = sample(filled(robot, **SHAPES["eight"]), STEPS, robot)
    new = sample(filled(robot, **SHAPES["triangle"], **turn), STEPS, robot)
    parts = [blended(old, new, cycle, cycles, 0.8) for cycle in range(cycles)]
    x, dx, ddx = (np.concatenate([getattr(part, key) for part in parts]) for key in new._fields[:3])
    for whole, before, after in zip((x, dx, ddx), old[:3], new[:3], strict=True):
        row = np.vstack([before, whole, after])
        jump = np.abs(np.diff(row, axis=0)).max(axis=1)
        assert np.allclose(whole[0], before[0], atol=1e-12 * np.abs(before).max())
        # The step over either end is no larger than those beside it.
        for end in (STEPS - 1, STEPS + len(whole) - 1):
            beside = np.delete(jump[end - 4 : end + 5], 4).max()
            assert jump[end] < 1.5 * beside + 1e-12
    if not robot.rotates:
        row = np.vstack([old.x[-1:], x, new.x[:1]])
        dt = 0.8 / STEPS
        assert np.allclose((row[2:] - row[:-2]) / (2 * dt), dx, atol=2e-3 * np.abs(dx).max())


@pytest.mark.parametrize("name", ["planar", "turning"])
def test_a_passage_by_way_of_a_small_motion_leaves_and_arrives_smoothly(name, request, folder):
    robot, cycles = request.getfixturevalue(name), 6
    turn = TURN if robot.rotates else {}
    old = sample(filled(robot, **SHAPES["eight"]), STEPS, robot)
    new = sample(filled(robot, **SHAPES["triangle"], **turn), STEPS, robot)
    middles = old.x.mean(axis=0), new.x.mean(axis=0)
    parts = [by_a_small_motion(old, new, middles, cycle, cycles, 0.8) for cycle in range(cycles)]
    x, dx, ddx = (np.concatenate([getattr(part, key) for part in parts]) for key in new._fields[:3])
    for whole, before, after in zip((x, dx, ddx), old[:3], new[:3], strict=True):
        np.testing.assert_allclose(whole[0], before[0], atol=1e-12 * np.abs(before).max())
        assert np.abs(whole[-1] - after[-1]).max() < 0.02 * np.abs(after).max()
    if not robot.rotates:
        dt = 0.8 / STEPS
        for whole, rate in ((x, dx), (dx, ddx)):
            found = (whole[2:] - whole[:-2]) / (2 * dt)
            assert np.abs(found - rate[1:-1]).max() < 5e-3 * np.abs(rate).max()
    # Half of the way through, what is left of the one and there of the other is small.
    middle = slice(int(2.5 * STEPS), int(3.5 * STEPS))
    assert np.ptp(x[middle], axis=0).max() < 0.5 * np.ptp(np.vstack([old.x, new.x]), axis=0).max()


@pytest.mark.parametrize("cycles", [1, 2])
def test_a_run_starts_at_rest_and_ends_on_the_motion(cycles, turning):
    new = sample(filled(turning, size=(0.05, 0.02), **TURN), STEPS, turning)
    rest = Kinematics(turning).position(turning.home)
    still = np.zeros_like(new.x)
    before = motion.Samples(still + rest, still, still)
    first = blended(before, new, 0, cycles, 0.8)
    last = blended(before, new, cycles - 1, cycles, 0.8)
    assert np.allclose(first.x[0], rest, atol=1e-15)
    assert np.abs(first.dx[0]).max() < 1e-12
    assert np.abs(first.ddx[0]).max() < 1e-9
    # One step before the end σ lacks 10/N³, its derivatives 30/N² and 60/N of their scales.
    share = 1 / (cycles * STEPS)
    scale = np.abs(new.x - rest).max()
    assert np.abs(last.x[-1] - new.x[-1]).max() < 12 * share**3 * scale
    length = cycles * 0.8
    slope = np.abs(new.dx).max()
    assert np.abs(last.dx[-1] - new.dx[-1]).max() < 40 * share**2 * (scale / length + slope)
    bound = 70 * share * (scale / length**2 + slope / length + np.abs(new.ddx).max())
    assert np.abs(last.ddx[-1] - new.ddx[-1]).max() < bound


def test_a_passage_between_rotations_has_their_angular_velocity(turning):
    old = sample(filled(turning, size=(0.05, 0.02), **TURN), STEPS, turning)
    new = sample(filled(turning, size=(0.02, 0.05), rotation_sin=((0.0,), (0.0,), (0.9,))),
                 STEPS, turning)  # fmt: skip
    found = blended(old, new, 0, 1, 0.8)
    R, dt = orientations(found, turning), 0.8 / STEPS
    omega = (R[2:] * R[:-2].inv()).as_rotvec() / (2 * dt)
    assert np.abs(omega - found.dx[1:-1, -3:]).max() < 1e-3 * np.abs(omega).max()
    alpha = (found.dx[2:] - found.dx[:-2]) / (2 * dt)
    assert np.abs(alpha - found.ddx[1:-1])[:, -3:].max() < 2e-3 * np.abs(alpha[:, -3:]).max()


def waypoints(tmp_path, text, robot, **keys):
    path = tmp_path / "points.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return filled(robot, shape="csv", file=str(path), **{"period": 1.0, "duration": 10.0, **keys})


def rows_of(values):
    return "".join(",".join(f"{value:.17g}" for value in row) + "\n" for row in values)


def test_a_csv_of_a_motion_gives_the_motion_back(tmp_path, planar):
    true = filled(planar, **SHAPES["fourier"], period=1.0, duration=10.0)
    errors = []
    for count in (50, 100):
        read = waypoints(tmp_path, rows_of(sample(true, count, planar).x), planar)
        found, expected = (sample(one, 400, planar) for one in (read, true))
        assert np.allclose(found.x[:: 400 // count], expected.x[:: 400 // count], atol=1e-15)
        errors.append(np.abs(found.x - expected.x).max())
    assert errors[1] < errors[0] / 14  # A cubic spline is of fourth order.


def test_header_comments_order_and_a_repeated_first_row_make_no_difference(tmp_path, planar):
    points = sample(filled(planar, **SHAPES["fourier"]), 20, planar).x
    time = np.arange(20)[:, None] / 20
    closed = np.vstack([points, points[:1]])
    plain = sample(waypoints(tmp_path, rows_of(points), planar), STEPS, planar)
    for text in (
        rows_of(closed),
        "# made by hand\n z , x \n" + rows_of(points[:, ::-1]),
        "\ufeffx,z\r\n" + rows_of(points).replace("\n", "\r\n") + "\r\n",
        "t,x,z\n" + rows_of(np.hstack([time, points])),
        "phase,x,z\n" + rows_of(np.hstack([time, points])),
        "t,x,z\n" + rows_of(np.hstack([np.vstack([time, [[1.0]]]) + 3.0, closed])),
    ):
        found = sample(waypoints(tmp_path, text, planar), STEPS, planar)
        assert np.allclose(found.x, plain.x, atol=1e-12)
        assert np.allclose(found.ddx, plain.ddx, atol=1e-8)


def test_phase_scales_with_the_period_and_unequal_times_are_kept(tmp_path, planar):
    rows = "0,0.1,0\n0.1,0.2,0.1\n0.5,0.3,0\n0.8,0.2,-0.1\n"
    one = waypoints(tmp_path, "phase,x,z\n" + rows, planar, period=2.0)
    x = sample(one, 10, planar).x
    assert np.allclose(x[[0, 1, 5, 8]], [[0.1, 0], [0.2, 0.1], [0.3, 0], [0.2, -0.1]], atol=1e-15)


def test_a_csv_may_have_the_rotation_too(tmp_path, turning):
    true = filled(turning, size=(0.05, 0.02), period=1.0, duration=10.0, **TURN)
    points = sample(true, 100, turning).x
    found = sample(waypoints(tmp_path, rows_of(points), turning), STEPS, turning)
    expected = sample(true, STEPS, turning)
    assert np.abs(found.x - expected.x).max() < 1e-5
    assert np.abs(found.dx - expected.dx).max() < 1e-3 * np.abs(expected.dx).max()
    still = sample(waypoints(tmp_path, rows_of(points[:, :3]), turning), STEPS, turning)
    assert np.abs(still.x[:, 3:]).max() == 0.0


def test_a_csv_that_changes_during_a_run_does_not_change_the_run(tmp_path, planar):
    one = waypoints(tmp_path, "0,0\n0.1,0\n0,0.1\n", planar)
    before = sample(one, 50, planar).x
    (tmp_path / "points.csv").unlink()
    assert np.array_equal(sample(one, 50, planar).x, before)


LONG = [f"{0.1 * np.cos(a):.6f},{0.1 * np.sin(a):.6f}\n" for a in np.arange(0, 6.2, 0.1)]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["no rows", "at least 3"]),
        ("x,z\n", ["0 rows", "at least 3"]),
        ("0.1,0.2\n", ["is 1 row ", "at least 3"]),
        ("0.1,0.2\n0.2,0.3\n0.1,0.2\n", ["2 rows besides the last", "at least 3"]),
        ("x,z\n0.1,0.2\n0.1,abc\n0.1,0.2\n", ["line 3, column z = 'abc'", "a number in m"]),
        ("0.1,abc\n0.1,0.2\n0.1,0.2\n", ["line 1, column z: not a number", "a number in m"]),
        ("x,z\n0.1,\n0.1,0.2\n", ["line 2, column z", "gap", "a number in m"]),
        ("x,z\n0.1,nan\n0.1,0.2\n", ["line 2, column z = nan", "gap", "finite"]),
        ("x,z\n0.1,inf\n0.1,0.2\n", ["line 2, column z = inf", "finite"]),
        ("0.1,0\n\n0.1,0.2\n0,0\n", ["line 2", "empty", "gap"]),
        ("0.1,0,1\n0.1,0.2,1\n", ["line 1", "3 columns", "no header", "2 are needed", "x, z"]),
        ("x,z\n0.1,0\n0.1,0.2,1\n", ["line 3", "3 columns; 2 are needed", "x, z"]),
        ("x;z\n0.1;0\n", ["line 1", "unknown columns", "separated by commas", "t, phase, x, z"]),
        ("x,y,z\n0,0,0\n", ["line 1", "column 'y'", "t, phase, x, z"]),
        ("t,x\n0,0\n", ["line 1", "column z is missing", "t, x", "x, z"]),
        ("x,x,z\n0,0,0\n", ["line 1", "column x appears twice"]),
        ("t,phase,x,z\n0,0,0,0\n", ["t and phase"]),
        ("t,x,z\n0,0,0\n0.2,1,0\n0.2,1,1\n0.9,0,1\n", ["line 4, column t = 0.2", "increasing"]),
        ("t,x,z\n0,0,0\n0.5,1,0\n1.5,1,1\n", ["line 4, column t = 1.5", "at most 1 ", "phase"]),
        ("t,x,z\n0,0,0\n0.1,1,0\n0.2,1,1\n", ["line 4, column t = 0.2", "0.8 s", "gap", "phase"]),
        ("t,x,z\n0,0,0\n.5,.1,0\n1,.1,.1\n", ["line 4, column x = 0.1", "jump at the", "repeat"]),
        ("".join(LONG[:31]), ["line 31", "jump at the seam", "0.199 m", "0.01 m", "5 times"]),
        (b"x,z\n\xff,0\n", ["byte 5", "UTF-8"]),
        ("x,z\n0.1,0\n1e308,0.2\n", ["line 3, column x = 1e+308", "in m from -1e+06 to 1e+06"]),
        ("x,z\n0.1,0\n0.2," + "9" * 100_000, ["line 3, column z", "finite"]),
        ("x,z\n0.1,0\n0.2," + "x" * 100_000, ["line 3, column z = 'xxx", "a number in m"]),
        ("t,x,z\n0,0,0\n1e-300,1,0\n.9,0,1\n", ["line 3, column t = 1e-300", "increasing"]),
        ("x,z\n" + "0.1,0.2\n" * 100_001, ["100001 waypoints", "at most 100000"]),
        ("x,z\n" + "# comment\n" * 400_000, ["longer than 4 MB"]),
        (b"\0" * 1000, ["line 1", "unknown columns"]),
    ],
)  # fmt: skip
def test_a_bad_csv_is_refused_in_one_line_with_file_place_value_and_remedy(
    text, words, tmp_path, planar
):
    with pytest.raises(rmj.ResonanceError) as caught:
        waypoints(tmp_path, text, planar)
    message = str(caught.value)
    assert "\n" not in message
    assert str(tmp_path / "points.csv") in message
    assert [word for word in words if word not in message] == []


@pytest.mark.parametrize(
    "text",
    ["root:secret:19000:0:99999:7:::\n", "secret\n", "12,secret\n", "secret,12\n", "0,secret,0\n"],
)
def test_what_a_file_holds_that_is_no_csv_is_not_told(text, tmp_path, planar):
    with pytest.raises(rmj.ResonanceError, match=r"points\.csv") as caught:
        waypoints(tmp_path, text, planar)
    assert "secret" not in str(caught.value)


def test_a_device_in_place_of_a_csv_is_refused_and_not_read(planar):
    with pytest.raises(rmj.ResonanceError, match="'/dev/zero': cannot be read: it is a device"):
        filled(planar, shape="csv", file="/dev/zero")


def test_harmonics_above_the_nyquist_limit_are_refused(planar):
    with pytest.raises(rmj.ResonanceError, match=r"sin has 501 harmonics .* = 500"):
        filled(
            planar,
            shape="fourier",
            period=1.0,
            duration=1.0,
            blend=0,
            offset=(0.1, 0.1),
            sin=((1e-6,) * 501, ()),
        )


def test_a_missing_csv_or_a_folder_is_refused_by_its_name(tmp_path, planar):
    for file, word in ((tmp_path / "no.csv", "does not exist"), (tmp_path, "is a folder")):
        with pytest.raises(rmj.ResonanceError, match=word) as caught:
            filled(planar, shape="csv", file=str(file))
        assert repr(str(file)) in str(caught.value)


def test_a_jump_in_rotation_at_the_seam_is_refused(tmp_path, turning):
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    rows = np.zeros((40, 6))
    rows[:, 0], rows[:, 1], rows[:, 5] = 0.1 * np.cos(angle), 0.1 * np.sin(angle), angle / 3
    with pytest.raises(rmj.ResonanceError, match=r"seam: .* the rotation changes by 2\.04 rad"):
        waypoints(tmp_path, rows_of(rows), turning)


def test_a_csv_beside_the_experiment_is_found_from_any_folder(tmp_path, monkeypatch):
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "points.csv").write_text("-0.3,0\n-0.25,0\n-0.3,0.05\n")
    path = tmp_path / "here" / "mine.toml"
    path.write_text('[robot]\nmjcf = "two_link.xml"\n[[motion]]\nshape = "csv"\n'
                    'file = "points.csv"\n')  # fmt: skip
    monkeypatch.chdir(tmp_path)
    loaded = rmj.load(path)
    assert loaded.motion[0].file == str(tmp_path / "here" / "points.csv")
    (tmp_path / "again.toml").write_text(loaded.to_toml())
    assert rmj.load(tmp_path / "again.toml").motion == loaded.motion
    assert rmj.optimum(loaded)[0].torque_reduction > 0


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"shape": "star"}, ["shape = 'star'", "'polygon'", "'csv'"]),
        ({"frame": "hand"}, ["frame = 'hand'", "'world', 'base' or 'tool'"]),
        ({"shape": "polygon", "corners": 2}, ["corners = 2", "greater than or equal to 3"]),
        ({"shape": "polygon", "rounding": 0}, ["rounding = 0", "greater than 0"]),
        ({"shape": "polygon", "rounding": 1.5}, ["rounding = 1.5", "less than or equal to 1"]),
        ({"corners": 5}, ["'ellipse' takes center, size, plane, not corners", "'polygon'"]),
        ({"file": "a.csv"}, ["'ellipse' takes", "not file", "'csv'"]),
        ({"offset": [0, 0]}, ["'ellipse' takes", "not offset", "'fourier'"]),
        ({"shape": "fourier"}, ["'fourier' needs offset"]),
        ({"shape": "csv"}, ["'csv' needs file"]),
        ({"shape": "csv", "file": "a.csv", "size": [1, 1]}, ["takes file, not size"]),
        ({"rotation_sin": [[0.1], [0.2]]}, ["rotation_sin has 2 rows", "rx, ry and rz"]),
    ],
)
def test_a_bad_key_is_refused_with_what_the_shape_takes(keys, words):
    plain = rmj.load("paper").replace({"motion": [{}]})
    with pytest.raises(rmj.ResonanceError) as caught:
        plain.replace({"motion": [keys]})
    message = str(caught.value)
    assert "\n" not in message
    assert "motion.0" in message
    assert [word for word in words if word not in message] == []


def test_what_does_not_fit_the_task_is_refused_by_key_and_value(planar, folder, turning):
    for keys, words in (
        ({"plane": ("x", "y")}, ["plane = ['x', 'y']", "y is not", "x, z"]),
        ({"rotation_sin": ((0.1,),) * 3}, ["rotation_sin", "no rotation", "task.coordinates"]),
    ):
        with pytest.raises(rmj.ResonanceError) as caught:
            filled(planar, **keys)
        assert [word for word in words if word not in str(caught.value)] == []
    flat = arm(folder, "x", "z")
    for frame in ("base", "tool"):
        with pytest.raises(rmj.ResonanceError, match=f"frame = '{frame}'.*degrees.*x, y and z"):
            filled(flat, frame=frame)
    with pytest.raises(rmj.ResonanceError, match=r"turns the tool by 3\.2 rad.*less than pi"):
        filled(turning, rotation_sin=((3.2,), (), ()))


def test_messages_name_the_experiment_and_the_motion():
    paper = rmj.load("paper")
    bad = paper.replace({"motion": [paper.motion[0].model_dump(), {"plane": ["x", "y"]}]})
    with pytest.raises(rmj.ResonanceError, match=r"^experiment 'paper': motion\.1: plane"):
        rmj.optimum(bad)


@pytest.mark.parametrize("shape", ["ellipse", "line", "eight", "polygon"])
def test_a_motion_without_a_size_is_reachable_with_margin_and_always_the_same(shape):
    plain = rmj.load("paper").replace({"motion": [{"shape": shape}], "robot.home": None})
    robot = build(plain)
    plan = plan_for(plain)
    one = plan.experiment
    assert one == plan_for(plain).experiment
    a, b = one.motion[0].size
    assert a == 2 * b
    assert 0.01 < a <= default_motion.SHARE * reach(robot)
    assert np.isclose(reach(robot), 0.55)  # The paper's links, 0.3 m and 0.25 m.
    (joints,) = plan.joints
    kinematics = Kinematics(robot)

    def conditioning(q):
        values = np.linalg.svd(kinematics.jacobian(q), compute_uv=False)
        return values[-1] / values[0]

    assert min(map(conditioning, joints.q)) > 0.49 * conditioning(robot.home)


def test_the_default_shrinks_near_a_joint_limit_and_near_the_edge_of_reach(folder, planar):
    near = SIX_JOINTS.replace('range="-3 3"', 'range="-3 1.7"')
    (folder / "near.xml").write_text(near)
    sizes = {}
    for name in ("six.xml", "near.xml"):
        robot = arm(folder, "x", "y", "z", mjcf=folder / name)
        one = default_motion.sized(filled(robot), Kinematics(robot), "motion")
        q = Kinematics(robot).follow(sample(one, 200, robot), robot.home, 0.8, "motion").q
        low, high = robot.model.jnt_range[robot.joint_id[2]]
        # Half of home's own distance, where that is less than 5 % of the range.
        margin = min(0.05 * (high - low), (high - robot.home[2]) / 2)
        assert q[:, 2].max() < high - 0.99 * margin
        sizes[name] = one.size[0]
    assert sizes["near.xml"] < sizes["six.xml"]
    kinematics = Kinematics(planar)
    free = default_motion.sized(filled(planar), kinematics, "motion")
    edge = default_motion.sized(filled(planar, center=(-0.5, 0.0)), kinematics, "motion")
    assert edge.size[0] < free.size[0]
    with pytest.raises(rmj.ResonanceError, match=r"motion: no size is given.*Give center"):
        default_motion.sized(filled(planar, center=(-0.5499, 0.0)), kinematics, "motion")
    with pytest.raises(rmj.ResonanceError, match=r"center = \[-0\.6, 0\.0\]: out of.*50\.0 mm"):
        default_motion.sized(filled(planar, center=(-0.6, 0.0)), kinematics, "motion")


def test_scipy_is_not_imported_before_a_csv_needs_it():
    program = (
        "import sys, resonance_mj, resonance_mj.motions.waypoints; "
        "sys.exit('scipy.interpolate' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0
