"""Values against the sections that take them, with errors of one line."""

import os
from collections.abc import Mapping
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from ..errors import ExperimentError
from ..text import cut, listed, nearest, shown

_PLAIN = {"model_type": "a table of keys is needed", "tuple_type": "a list is needed"}
"""What pydantic says in words of Python."""

_OF_ITS_TYPE = ("finite_number", "greater_than", "greater_than_equal", "less_than_equal")
"""Where a value is of the right type, and its size is not."""

NESTED = "nested too deeply; `resonance-mj keys` lists every key"
"""What is wrong with brackets in brackets."""

NAMED = ("joint", "keys", "fixed")
"""Tables whose keys the arm or the user names."""

Model = TypeVar("Model", bound=BaseModel)


def validated(model: type[Model], values: dict[str, Any], source: str) -> Model:
    """Values as a section.

    Raises:
        ExperimentError: the first key or value that is not valid, and what would be.
    """
    try:
        return model.model_validate(plain(values))
    except ValidationError as error:
        raise ExperimentError(_one_line(model, error, source)) from None
    except RecursionError:
        raise ExperimentError(f"{source}: {NESTED}") from None


def plain(value: Any) -> Any:
    """A value as a TOML file would have it: of NumPy's numbers and arrays, tuples and paths."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    return [plain(item) for item in value] if isinstance(value, list | tuple) else value


def _one_line(model: type[BaseModel], error: ValidationError, source: str) -> str:
    """The problem that fits the input best, as one line."""
    problems = error.errors(include_url=False)
    # Of a union's branches pydantic reports each; the one that looked deepest fits the input best.
    first = max(
        problems,
        key=lambda p: (p["type"] == "extra_forbidden", len(p["loc"]), p["type"] in _OF_ITS_TYPE),
    )
    names = _names(model)
    words = [str(part) for part in first["loc"]]
    key = ".".join(
        word
        for before, word in zip(["", *words], words, strict=False)
        if word.isdigit() or word in names or before in NAMED
    )
    if first["type"] == "extra_forbidden":
        key = ".".join(map(cut, words))
        section = _section(model, words[:-1])
        return (
            f"{source}: {key}: unknown key{nearest(words[-1], section)}; "
            f"valid keys here are {listed(section)}"
        )
    if first["type"] == "missing":
        return f"{source}: {key}: missing; it has no default"
    message = _PLAIN.get(first["type"], first["msg"].removeprefix("Value error, "))
    message = message.replace("Tuple", "list").replace(" after validation", "")
    message = message[0].lower() + message[1:]
    where = f"{source}: {key}" if key else source
    if not isinstance(first["input"], (dict, BaseModel)):
        where += f" = {shown(first['input'])}"
    return f"{where}: {message}"


def _names(model: type[BaseModel]) -> set[str]:
    """Every key of a section and of those inside it."""
    inside = [_inside(field.annotation) for field in model.model_fields.values()]
    aliases = {field.alias for field in model.model_fields.values() if field.alias}
    found = (_names(one) for one in inside if one is not None)
    return (set(model.model_fields) | aliases).union(*found)


def _section(model: type[BaseModel], path: list[str]) -> list[str]:
    """Keys of the section at a path of keys and indices."""
    for key in path:
        if key in model.model_fields:
            model = _inside(model.model_fields[key].annotation) or model
    return list(model.model_fields)


def _inside(annotation: Any) -> type[BaseModel] | None:
    """The section that a field holds, alone, as an option or in a tuple."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next(filter(None, map(_inside, get_args(annotation))), None)
