"""A shard of a sweep: experiments that are simulated together, and what is kept of them."""

from collections.abc import Sequence

from ..errors import ResonanceError
from ..experiments.experiment import Experiment
from ..plan.plan import Followed, plan_for
from ..simulation.simulation import simulate_together
from .dataset import Outcome


def simulated(
    experiments: Sequence[Experiment],
    threads: int = 0,
    followed: Followed | None = None,
    *,
    predict: bool = False,
) -> list[Outcome]:
    """What comes of experiments, those that can begin together; only what is said of each is kept.

    Args:
        experiments: what to simulate.
        threads: how many to use; 0 for all cores.
        followed: what those before have in common with these, taken from here and added here.
        predict: whether to find as well if they diverge by the linear analysis.
    """
    followed = {} if followed is None else followed
    plans, outcomes = {}, {}
    for index, experiment in enumerate(experiments):
        if "samples" not in experiment.simulation.model_fields_set:
            experiment = experiment.replace({"simulation.samples": 1})
        try:
            plan = plan_for(experiment, followed, looks=False)
            _ = plan.optima
        except ResonanceError as error:
            outcomes[index] = Outcome.refused(str(error))
        else:
            plans[index] = plan
    runs = simulate_together(list(plans.values()), threads=threads)
    for index, run in zip(plans, runs, strict=True):
        diverges = bool(plans[index].unstable) if predict else None
        outcomes[index] = Outcome.of(run, diverges)
    return [outcomes[index] for index in range(len(experiments))]
