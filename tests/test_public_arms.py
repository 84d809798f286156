"""Arms that others made, with nothing given but their file: `make test-robots`."""

import re

import commercial_arms
import pytest
from public_arms import ARMS, HEADS, measure, row

pytestmark = pytest.mark.robots


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
def test_an_arm_of_a_public_wheel_comes_to_what_is_expected_of_it(arm, record_property):
    found = measure(str(arm.path), arm.changes)
    record_property(HEADS, row(arm, found))
    assert not found.wrong_ok, f"says ok, and the judge finds {found.judged}"
    assert found.meets(arm.expected), f"{found.status}: {found.said}"


@pytest.mark.parametrize(
    "case", commercial_arms.CASES, ids=lambda case: "-".join(vars(case).values())
)
def test_a_commercial_arm_comes_to_the_bounded_optimum_in_20_cycles_or_says_why_not(
    case, record_property
):
    run, found = commercial_arms.measure(case)
    record_property(commercial_arms.HEADS, commercial_arms.row(case, run, found))
    assert not found.wrong_ok, f"says ok, and the judge finds {found.judged}"
    if case in commercial_arms.SAID:
        assert re.search(commercial_arms.SAID[case], "\n".join((run.message, *run.notes)))
    else:
        assert found.at_optimum, f"{found.status}: {found.said}: {found.judged}"
