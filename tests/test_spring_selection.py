"""Parts of a catalogue: what is chosen is the best of all combinations that can be tried."""

from itertools import product

import numpy as np
import pytest
from scipy.optimize import minimize

import resonance_mj as rmj
from resonance_mj.errors import OutputError
from resonance_mj.evaluation import spring_selection
from resonance_mj.evaluation.spring_catalogue import Bought, read
from resonance_mj.evaluation.spring_parts import spring_parts
from resonance_mj.evaluation.spring_selection import selections

COUPLED = {
    "springs.element": [{"name": "both", "joints": ["joint1", "joint2"], "radii": [1.0, -0.5]}],
    "motion.0.duration": 12.0,
    "motion.1.duration": 12.0,
}
PARTS = (
    Bought("a", 2.0, 30.0, 6.0, 1.0),
    Bought("b", 6.0, 20.0, 6.0, 1.0),
    Bought("c", 15.0, 40.0, 1.2, 1.0),
    Bought("d", 30.0, 25.0, 6.0, 1.0, (-5.0, 30.0)),
)


@pytest.fixture(scope="module")
def asked():
    return spring_parts(rmj.simulate(rmj.load("two-link-transfer").replace(COUPLED)))


def alongs(asked):
    return {
        "joint1": np.array([1.0, 0.0]),
        "joint2": np.array([0.0, 1.0]),
        "both": np.array([1, -0.5]),
    }


def left_by(asked, parts, motions, shares=None):
    """The least that given parts leave at any rest that they bear; inf where they bear none."""
    q = np.concatenate([motion.q for motion in motions])
    bounds, used = [], [(along, part) for along, part in parts if part is not None]
    for along, part in used:
        x, home = q @ along, asked.home @ along
        away = min(part.travel, part.torque / part.rate)
        low = max(x.max() - away, home + part.preload[0] / part.rate)
        high = min(x.min() + away, home + part.preload[1] / part.rate)
        if low > high:
            return np.inf
        bounds.append((low, high))

    def each(rests):
        found = []
        for motion in motions:
            torque = motion.total.copy()
            for (along, part), rest in zip(used, rests, strict=True):
                torque += np.outer(part.rate * (motion.q @ along - rest), along)
            found.append((torque**2).sum(axis=1).mean())
        return np.array(found)

    def goal(rests):
        of = each(rests)
        return float((of / shares).max()) if shares is not None else float(of.mean())

    if not used:
        return goal([])
    start = np.mean(bounds, axis=1)
    if shares is None:
        return float(minimize(goal, start, bounds=bounds, options={"ftol": 1e-15}).fun)
    begin = [*start, goal(start)]
    least = {
        "type": "ineq",
        "fun": lambda v: v[-1] - each(v[:-1]) / shares,
    }
    found = minimize(
        lambda v: v[-1],
        begin,
        bounds=[*bounds, (0, None)],
        constraints=least,
        method="SLSQP",
        options={"ftol": 1e-12, "maxiter": 300},
    )
    return float(found.fun)


@pytest.mark.parametrize("together", [None, "mean", "worst"])
def test_no_other_combination_of_parts_leaves_less(asked, together):
    chosen = selections(asked, PARTS, together)
    groups = [asked.motions] if together else [(motion,) for motion in asked.motions]
    for one, motions in zip(chosen, groups, strict=True):
        shares = None
        if together == "worst":
            shares = np.array([(motion.total**2).sum(axis=1).mean() for motion in motions])
            assert one.without == pytest.approx(shares)
        along = alongs(asked).values()
        every = {
            parts: left_by(asked, list(zip(along, parts, strict=True)), motions, shares)
            for parts in product((None, *PARTS), repeat=3)
        }
        best = min(every.values())
        mine = max(one.left / shares) if shares is not None else one.left.mean()
        assert mine == pytest.approx(best, rel=1e-4)
        assert every[tuple(each.part for each in one.mounted)] == pytest.approx(best, rel=1e-4)
        for each in one.mounted:
            if each.part is None:
                assert np.isnan(each.rest)
                continue
            x = (
                np.concatenate([motion.q for motion in motions]) @ alongs(asked)[each.on]
                - each.rest
            )
            assert np.abs(x).max() <= each.part.travel * (1 + 1e-9)
            assert np.abs(x).max() * each.part.rate <= each.part.torque * (1 + 1e-9)


def test_branches_that_cannot_be_best_are_not_tried(asked, monkeypatch):
    many = tuple(Bought(str(k), k, 100.0, 10.0) for k in np.geomspace(0.5, 40, 30))
    tried = []
    relaxed = spring_selection.Relaxation.relaxed
    monkeypatch.setattr(
        spring_selection.Relaxation,
        "relaxed",
        lambda self, node: (tried.append(node), relaxed(self, node))[1],
    )
    (first, _) = selections(asked, many)
    assert any(each.part for each in first.mounted)
    assert len(tried) < 31**3 / 20
    monkeypatch.setattr(spring_selection, "NODES", 10)
    with pytest.raises(OutputError, match="the best is not sure"):
        selections(asked, many)


def test_of_equals_the_cheapest_is_taken_and_none_where_no_part_helps(asked):
    twins = (Bought("dear", 6.0, 50.0, 9.0, 3.0), Bought("cheap", 6.0, 50.0, 9.0, 1.0))
    for one in selections(asked, twins):
        assert {each.part.part for each in one.mounted if each.part} <= {"cheap"}
        assert any(each.part for each in one.mounted)
    stiff = (Bought("stiff", 1e4, 1e6, 9.0),)
    for one in selections(asked, stiff):
        assert all(each.part is None for each in one.mounted)
        assert one.left == pytest.approx(one.without)


def test_a_part_goes_only_where_it_fits(asked):
    parts = (Bought("arm", 6.0, 50.0, 9.0, fits=("joint2",)),)
    for one in selections(asked, parts):
        assert {each.on for each in one.mounted if each.part} <= {"joint2"}


def test_one_set_for_all_motions_leaves_no_less_than_a_set_for_each(asked):
    each = np.array([one.left[0] for one in selections(asked, PARTS)])
    for together in ("mean", "worst"):
        (same,) = selections(asked, PARTS, together)
        assert same.motions == (1, 2)
        assert (same.left >= each * (1 - 1e-6)).all()
        assert (same.left >= same.best * (1 - 1e-6)).all()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("part,rate,torque,travel,price\na,1,2,3,-1\n", "price = '-1': a number of 0 or more"),
        ("part,rate,torque,travel,least_preload\na,1,2,3,x\n", "least_preload = 'x': a number is"),
        (
            "part,rate,torque,travel,least_preload,most_preload\na,1,2,3,4,1\n",
            "least_preload = 4 is above most_preload = 1",
        ),
    ],
)
def test_a_cell_that_cannot_be_is_refused_with_its_line(tmp_path, text, says):
    path = tmp_path / "parts.csv"
    path.write_text(text)
    with pytest.raises(OutputError) as error:
        read(path)
    assert says in str(error.value)
    assert "line 2" in str(error.value)


def test_preload_bounds_where_a_part_may_rest():
    part = Bought("p", 10.0, 20.0, 5.0, 0.0, (-2.0, 4.0))
    rests = part.rests(-0.5, 0.5, 0.1)
    assert rests == pytest.approx((0.1 - 0.2, 0.1 + 0.4))
    assert part.rests(-3.0, 3.0, 0.1) is None
