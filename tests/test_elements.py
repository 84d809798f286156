"""Elastic elements: MuJoCo exerts what they say, the law finds the best, bad ones are refused."""

import json
import subprocess
import sys

import mujoco
import numpy as np
import pytest
from scipy.optimize import minimize

import resonance_mj as rmj
from resonance_mj.errors import OutputError, ResonanceError
from resonance_mj.evaluation.spring_catalogue import read
from resonance_mj.pictures import stiffnesses
from resonance_mj.pictures.figures import catalogue
from resonance_mj.pictures.figures.springs import _exerted_in
from resonance_mj.pictures.film import plots
from resonance_mj.pictures.film.frame_data import of_run
from resonance_mj.plan.plan import plan_for
from resonance_mj.results.cycles import kept
from resonance_mj.robots import elastic
from resonance_mj.springs.elements import Elements, regressor

CUBIC = [{"kind": "cubic", "joints": ["joint1"]}, {"kind": "cubic", "joints": ["joint2"]}]
SLOPES = [
    {"name": f"{kind} {joint}", "kind": kind, "joints": [joint], "rest": rest}
    for joint, rest in (("joint1", 4.0), ("joint2", -1.5))
    for kind in ("above", "below")
]
PULLEYS = [{"joints": ["joint1", "joint2"], "radii": [0.5, -1.5]}]
KINDS = {"cubic": CUBIC, "two slopes": SLOPES, "over two joints": PULLEYS}
LIMITED = [{"kind": "cubic", "joints": ["joint1"], "stiffness": [2.0, 12.0]}]


def with_elements(elements, name="two-link-transfer", **changes):
    return rmj.load(name).replace({"springs.element": elements} | changes)


@pytest.mark.parametrize("elements", [*KINDS.values(), LIMITED])
def test_mujocos_tendons_exert_what_the_elements_say(elements):
    plan = plan_for(with_elements(elements))
    robot, rng = plan.robot, np.random.default_rng(1)
    size = sum(len(one.parameters) for one in robot.elements)
    springs = Elements(robot.elements, rng.uniform(1, 5, size))
    elastic.write(robot.model, springs)
    assert np.allclose(elastic.read(robot.model, robot.elements).parameters, springs.parameters)
    data = mujoco.MjData(robot.model)
    q = robot.home + rng.uniform(-1.5, 1.5, (20, 2))
    for pose, torque in zip(q, springs.torque(q), strict=True):
        data.qpos[robot.qpos_address] = pose
        mujoco.mj_forward(robot.model, data)
        assert np.allclose(data.qfrc_passive[robot.dof_address], torque, atol=1e-9)


def test_an_element_that_pushes_without_stiffness_is_a_constant_force():
    plan = plan_for(with_elements(PULLEYS))
    robot = plan.robot
    springs = Elements(robot.elements, np.array([0.0, 3.0]))
    elastic.write(robot.model, springs)
    data = mujoco.MjData(robot.model)
    data.qpos[robot.qpos_address] = robot.home
    mujoco.mj_forward(robot.model, data)
    assert np.allclose(data.qfrc_passive[robot.dof_address], [1.5, -4.5], atol=1e-6)


def least(q, torque, elements, own):
    """Least mean of torque² that any springs leave, by a solver of its own on a dense grid."""
    n = q.shape[1]
    z = q - q.mean(axis=0)
    one = np.ones_like(z)
    columns = [np.where(np.arange(n) == j, sign, 0.0) for j in range(n) for sign in (-z, one)]
    columns = [column for j, column in enumerate(columns) if own[j // 2]]
    phi = np.stack([*columns, *np.moveaxis(regressor(elements, q), 2, 0)], axis=2)
    at = len(columns)
    rows, ends = [], []
    for element in elements:
        mine = np.zeros((401 if element.kind == "cubic" else 1, phi.shape[2]))
        x = np.linspace(*element.travel, len(mine)) - element.center
        slopes = [np.ones_like(x), 2 * x, 3 * x**2] if element.kind == "cubic" else [x**0]
        mine[:, at : at + len(slopes)] = np.transpose(slopes)
        at += len(element.parameters)
        rows.append(mine)
        ends.append(np.full(len(mine), element.stiffness[0]))
        if np.isfinite(element.stiffness[1]):
            rows.append(-mine)
            ends.append(np.full(len(mine), -element.stiffness[1]))
    A, b = np.concatenate(rows), np.concatenate(ends)
    flat = phi.reshape(-1, phi.shape[2])
    scale = np.linalg.norm(flat, axis=0)
    scale[scale == 0] = 1.0
    R, target = np.linalg.qr(flat / scale)[1], torque.ravel()
    linear = (flat / scale).T @ target
    found = minimize(
        lambda p: p @ R.T @ R @ p / 2 - linear @ p,
        np.zeros(len(scale)),
        jac=lambda p: R.T @ (R @ p) - linear,
        constraints={
            "type": "ineq",
            "fun": lambda p: A / scale @ p - b,
            "jac": lambda p: A / scale,
        },
        method="SLSQP",
        options={"maxiter": 500, "ftol": 1e-14},
    )
    return float(((target - flat / scale @ found.x) ** 2).sum() / len(q))


@pytest.mark.parametrize("kind", KINDS)
def test_the_law_comes_within_a_percent_of_the_optimum_of_another_solver(kind):
    experiment = with_elements(KINDS[kind])
    run = rmj.simulate(experiment)
    assert run.status == "ok"
    own = [kind == "over two joints"] * 2
    for motion, joints, loaded in zip(run.motions, run.plan.joints, run.plan.loaded, strict=True):
        best = least(joints.q, loaded.torque(joints), run.plan.robot.elements, own)
        assert motion.torque_squared_optimal == pytest.approx(best, rel=1e-3)
        assert motion.torque_squared[-1] == pytest.approx(best, rel=0.01)
        assert motion.cycles_to_optimum <= 15


def test_springs_over_all_pairs_of_seven_joints_leave_less_than_half_of_what_others_do():
    joints = [f"joint{j}" for j in range(1, 8)]
    pairs = [{"joints": [a, b]} for i, a in enumerate(joints) for b in joints[i + 1 :]]
    run = rmj.simulate(with_elements(pairs, "seven-joint"))
    alone = rmj.optimum(rmj.load("seven-joint"))[0]
    (motion,) = run.motions
    assert run.status == "ok"
    assert motion.cycles_to_optimum <= 25
    assert motion.torque_squared[-1] == pytest.approx(motion.torque_squared_optimal, rel=0.01)
    assert motion.torque_squared_optimal < 0.5 * alone.torque_squared
    best = least(
        run.plan.joints[0].q,
        run.plan.loaded[0].torque(run.plan.joints[0]),
        run.plan.robot.elements,
        [True] * 7,
    )
    assert rmj.optimum(run.experiment)[0].torque_squared >= best * (1 - 1e-6)


def test_a_cubic_element_is_nowhere_softer_or_stiffer_than_its_bounds():
    for best in rmj.optimum(with_elements(LIMITED)):
        (element,), p = best.springs.others
        x = np.linspace(*element.travel, 10_001) - element.center
        stiffness = p[0] + 2 * p[1] * x + 3 * p[2] * x**2
        assert stiffness.min() >= 2.0 - 1e-4
        assert stiffness.max() <= 12.0 + 1e-4


def test_a_linear_element_over_one_joint_is_that_joints_spring():
    own = rmj.optimum(rmj.load("two-link-transfer"))
    changed = with_elements([{"joints": ["joint1"], "stiffness": [-100.0, 100.0]}])
    for alone, element in zip(own, rmj.optimum(changed), strict=True):
        assert element.torque_squared == pytest.approx(alone.torque_squared, rel=1e-9)
        assert element.stiffness[0] == 0.0
        assert element.springs.others.parameters[0] == pytest.approx(alone.stiffness[0], rel=1e-6)


def test_elements_step_together_as_one_by_one_and_a_saved_run_goes_on(tmp_path):
    shorter = {"motion.0.duration": 12.0, "motion.1.duration": 12.0}
    each = [with_elements(PULLEYS, **shorter), with_elements(PULLEYS, **shorter)]
    each[1] = each[1].replace({"springs.element.0.stiffness": [0.5, 1.0]})
    runs = rmj.simulate_many(each)
    for experiment, together in zip(each, runs, strict=True):
        alone = rmj.simulate(experiment)
        for name in alone.data.variables:
            assert np.array_equal(alone.data[name], together.data[name]), name
    runs[1].save(tmp_path / "run")
    loaded = rmj.Run.load(tmp_path / "run")
    longer = each[1].replace({"motion": [each[1].motion[1].model_dump(exclude_none=True)]})
    whole = each[1].replace({"motion.1.duration": 24.0})
    rest = rmj.simulate(longer, after=loaded).data["torque_squared"].values
    assert np.array_equal(rest, rmj.simulate(whole).data["torque_squared"].values[24:])


def test_the_handover_to_elements_keeps_the_torque_and_leaves_the_springs_nothing():
    found = rmj.certify(rmj.simulate(with_elements(PULLEYS)))
    assert all(one.holds for equation in ("(9)", "(11)", "(12)") for one in found.of(equation))
    assert all("other elements" in one.note for one in found.of("(15)") + found.of("(22)"))


PUBLISHED = {
    "no springs": {"rms": (18.1, 15.9), "power": 46.4},
    "linear": {"k": (57, 26), "rms": (11.7, 10.3), "power": 35.2},
    "two slopes": {"k": (12, 97, 51.5, 8), "rms": (5.7, 4.3), "power": 19.2},
}
"""Nasiri et al., IEEE/ASME Transactions on Mechatronics, 2016, Table I."""
ERROR = {"linear": (9, 6), "two slopes": (6, 6, 6, 6)}


@pytest.mark.parametrize("springs", PUBLISHED)
def test_the_published_springs_of_another_arm_are_found(springs):
    names = {"linear": "point-mass-arm", "two slopes": "point-mass-arm-two-slopes"}
    experiment = rmj.load(names.get(springs, "point-mass-arm"))
    if springs == "no springs":
        experiment = experiment.replace(
            {"springs.joint": {"joint1": {"kind": "none"}, "joint2": {"kind": "none"}}}
        )
    run = rmj.simulate(experiment)
    (motion,), published = run.motions, PUBLISHED[springs]
    last = motion.samples.isel(time=motion.samples["cycle_of_sample"].values == motion.cycles[-1])
    tau, dq = last["tau"].values, last["dq"].values
    assert run.status == "ok"
    assert np.sqrt((tau**2).mean(axis=0)) == pytest.approx(published["rms"], rel=0.08)
    assert np.abs(tau * dq).sum(axis=1).mean() == pytest.approx(published["power"], rel=0.09)
    k = [values[-1] for values in motion.parameters.values()] or motion.stiffness[-1]
    for found, value, error in zip(k, published.get("k", ()), ERROR.get(springs, ()), strict=False):
        assert found == pytest.approx(value, abs=error)


@pytest.mark.parametrize(
    ("element", "says"),
    [
        ({"joints": ["joint3"]}, "no joint 'joint3' (did you mean 'joint2'"),
        ({"joints": ["joint1"], "radii": [1.0, 2.0]}, "one per joint"),
        ({"joints": ["joint1"], "radii": [0.0]}, "radius of 0"),
        ({"joints": ["joint1", "joint1"]}, "named once"),
        ({}, "give either joints"),
        ({"joints": ["joint1"], "tendon": "t"}, "give either joints"),
        ({"tendon": "t"}, "no such tendon"),
        ({"joints": ["joint1"], "kind": "quartic"}, "linear"),
        ({"joints": ["joint1"], "stiffness": [3.0, 2.0]}, "lower <= upper"),
        ({"joints": ["joint1"], "stiffness": [-1.0, 2.0], "rest": 0.0}, "not convex"),
        ({"joints": ["joint1"], "kind": "cubic", "rest": [0.0, 1.0]}, "a given one"),
        ({"joints": ["joint1"], "kind": "above", "rest": 40.0}, "the joints bring it to"),
    ],
)
def test_an_element_that_cannot_be_is_refused_in_one_line(element, says):
    with pytest.raises(ResonanceError) as error:
        plan_for(with_elements([element]))
    assert says in str(error.value)
    assert "springs.element" in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("elements", [PULLEYS, SLOPES])
def test_at_the_ends_of_an_elements_range_the_cost_has_risen_by_what_was_asked(elements):
    best = rmj.optimum(with_elements(elements))[1]
    given = best.springs.others
    for (element, p), ends in zip(given.each(), best.element_ranges(0.01), strict=True):
        alone = Elements((element,), p)
        needed = best.torque + alone.torque(best.q)
        for end in ends:
            if end in element.stiffness:  # at which it has risen less
                continue
            left = needed - Elements((element,), np.array([end, 0.0][: len(p)])).torque(best.q)
            if len(p) > 1:  # with the best offset, along its radii
                left -= (left @ element.radii).mean() / (element.radii**2).sum() * element.radii
            risen = (left**2).sum(axis=1).mean() - best.torque_squared
            assert risen == pytest.approx(0.01 * best.torque_squared_without_springs, rel=2e-3)


def test_elements_are_drawn_in_place_of_springs_that_are_not_there():
    none = {"joint1": {"kind": "none"}, "joint2": {"kind": "none"}}
    short = {"motion.0.duration": 5.0, "motion.1.duration": 5.0}
    for joints, panels in ((none, 2 + 1 + 2 + 1), ({}, 2 + 1 + 4 * 2 + 1)):
        run = rmj.simulate(with_elements(PULLEYS, **{"springs.joint": joints}, **short))
        titles = [ax.get_title(loc="left") for ax in catalogue.named("overview").draw([run]).axes]
        assert len(titles) == panels
        assert sum("stiffness k of joint1-joint2 [N/m]" in title for title in titles) == 1
        named = [spring.name for spring in plots._springs(run)]
        assert named == [*(["joint1", "joint2"] if not joints else []), "joint1-joint2"]
    (element,) = stiffnesses.elements(run)
    assert element.time.tolist() == list(range(11))
    values = run.data["parameters_per_cycle"].values[:, 0]
    assert element.k.tolist() == [values[0], *values]


def test_elements_of_one_name_are_refused():
    with pytest.raises(ResonanceError, match="several elements are called 'joint1'"):
        with_elements([{"joints": ["joint1"]}, {"joints": ["joint1"], "kind": "cubic"}])


def test_what_cannot_be_told_apart_is_said_and_shared_evenly():
    plan = plan_for(with_elements([{"name": name, "joints": ["joint1"]} for name in "ab"]))
    assert "along motion.0 a and b cannot be told apart" in plan.notes[0]
    k_a, _, k_b, _ = plan.optima[0].springs.others.parameters
    assert k_a == pytest.approx(k_b, rel=0.01)
    assert not any("told apart" in note for note in plan_for(with_elements(SLOPES)).notes)


def test_a_tendon_of_the_robots_file_is_an_element(tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(
        """<mujoco><compiler angle="radian"/><worldbody><body><joint name="a" axis="0 1 0"/>
        <geom type="capsule" size=".02" fromto="0 0 0 .3 0 0" mass="1"/><body pos=".3 0 0">
        <joint name="b" axis="0 1 0"/>
        <geom type="capsule" size=".02" fromto="0 0 0 .3 0 0" mass="1"/>
        <site name="tool" pos=".3 0 0"/></body></body></worldbody>
        <tendon><fixed name="both" stiffness="4" springlength="0.7">
        <joint joint="a" coef="1"/><joint joint="b" coef="-2"/></fixed></tendon></mujoco>"""
    )
    experiment = rmj.load(path).replace({"robot.home": [0.4, 0.9]})
    taken = plan_for(experiment.replace({"springs.element": [{"tendon": "both"}]}))
    (element,) = taken.robot.elements
    assert element.radii.tolist() == [1.0, -2.0]
    assert element.stiffness == (4.0, 4.0)
    assert element.rest == (0.7, 0.7)
    assert taken.optima[0].springs.others.parameters.tolist() == [4.0, 0.0]
    assert any("elements, adjusted" in note and "both" in note for note in taken.notes)


def command(*arguments):
    return subprocess.run(
        [sys.executable, "-P", "-m", "resonance_mj.cli", *map(str, arguments)],
        capture_output=True,
        text=True,
    )


def test_the_springs_that_a_run_asks_for_are_listed_and_chosen_from_a_catalogue(tmp_path):
    run = rmj.simulate(rmj.load("two-link-transfer"))
    run.save(tmp_path / "run")
    catalogue = tmp_path / "parts.csv"
    catalogue.write_text(
        "part,rate,torque,travel,price\nsoft,2.5,20,4,5\nstiff,30,60,2,9\ncheap,30,60,2,1\n"
        "weak,30,0.1,2,1\n"
    )
    done = command("springs", tmp_path / "run", "--catalogue", catalogue, "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    first, second = found["motions"]
    assert first["parts"][0]["stiffness"] == pytest.approx(3.066, abs=1e-3)
    # k² of a spring at its peak is twice what it stores times k.
    for part in (*first["parts"], *second["parts"]):
        stored = part["peak"] ** 2 / (2 * abs(part["stiffness"]))
        assert part["energy"] == pytest.approx(stored)
    worth = found["worth"]
    assert worth["adjusted"] < worth["fixed"] < worth["none"]
    optima = [motion.torque_squared_optimal for motion in run.motions]
    assert worth["adjusted"] == pytest.approx(np.mean(optima), rel=1e-3)
    chosen = [
        {each["on"]: each["part"]["part"] for each in one["parts"]} for one in found["catalogue"]
    ]
    assert chosen[1] == {"joint1": "cheap", "joint2": "soft"}


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("part,rate,torque\na,1,2\n", "has no column travel"),
        ("part,rate,torque,travel\na,-1,2,3\n", "line 2: rate = '-1'"),
        ("part,rate,torque,travel\n", "has no parts"),
    ],
)
def test_a_catalogue_that_is_none_is_refused(tmp_path, text, says):
    (tmp_path / "parts.csv").write_text(text)
    with pytest.raises(OutputError) as error:
        read(tmp_path / "parts.csv")
    assert says in str(error.value)
    assert "\n" not in str(error.value)


def test_weights_move_elements_over_several_joints_and_no_others():
    heavy = {"springs.weights": [1.0, 100.0]}
    for elements, moves in ((PULLEYS, True), (CUBIC, False)):
        alone = {} if moves else {"springs.joint": {}}
        none = {"joint1": {"kind": "none"}, "joint2": {"kind": "none"}}
        keys = {"springs.joint": none} if moves else alone
        even = rmj.optimum(with_elements(elements, **keys))
        weighed = rmj.optimum(with_elements(elements, **keys, **heavy))
        for one, other in zip(even, weighed, strict=True):
            cost = [(best.torque**2).mean(axis=0) @ [1.0, 100.0] for best in (one, other)]
            if moves:
                assert cost[1] < 0.99 * cost[0]
                assert other.torque_squared > one.torque_squared
            else:
                assert cost[1] == pytest.approx(cost[0], rel=1e-4)
    run = rmj.simulate(with_elements(PULLEYS, **{"springs.joint": none}, **heavy))
    for motion in run.motions:
        assert motion.torque_squared[-1] == pytest.approx(motion.torque_squared_optimal, rel=0.01)


def test_the_figure_shows_what_springs_and_elements_exert_together():
    run = rmj.simulate(with_elements(CUBIC))
    last = kept(run)[-1]
    drawn = _exerted_in(last, run.elements(last.parameters), 0)
    needed = run.plan.loaded[1].torque(run.plan.joints[1])[:, 0]
    assert np.abs(drawn.needed - needed).max() < 0.03 * np.abs(needed).max()
    assert (drawn.motor**2).mean() < 0.1 * (drawn.needed**2).mean()
    # And the film takes its arrows from the same.
    shown = of_run(run, np.array([79.5]), "run")
    assert shown.spring(int(shown.sample[0]))[0] == pytest.approx(
        drawn.spring[round(0.5 / 1e-3)], rel=0.02
    )
