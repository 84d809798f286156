"""Every key of an experiment file, for those who write one."""

from pydantic import BaseModel

from ..text import shown
from .expectations import Expect, Expected
from .experiment import Experiment
from .law_section import Law
from .motion_section import Motion
from .sections import JointSpring, Robot, Simulation, Springs, Task

_SECTIONS: dict[str, type[BaseModel]] = {
    "robot": Robot,
    "task": Task,
    "simulation": Simulation,
    "motion": Motion,
    "law": Law,
    "springs": Springs,
    "springs.joint.NAME": JointSpring,
    "expect": Expect,
    "expect.stiffness": Expected,
}


def describe() -> list[tuple[str, str, str]]:
    """Every key of an experiment file, its default as TOML and its meaning."""
    rows: list[tuple[str, str, str]] = []
    sections: dict[str, type[BaseModel]] = {"": Experiment, **_SECTIONS}
    for section, model in sections.items():
        for name, field in model.model_fields.items():
            if section == "" and name in _SECTIONS:
                continue
            key = ".".join(filter(None, ("motion.0" if section == "motion" else section, name)))
            default = "(none)" if field.is_required() else shown(field.default)
            rows.append((key, default, field.description or ""))
    return rows
