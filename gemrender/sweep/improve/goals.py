"""Goals: what of a stone should be large, as an expression over its measures; parsed, never run as Python.

::

    iso - 0.5*leak                  values of measures; `measure.key`, a measure's first value, or a key alone
    min(iso, 90)                    min, max, abs
    worst(inoue, 15)                the least over tilts up to 15 degrees; `mean`: their mean
    iso - 2*spread(iso)             `spread`: standard deviation under what is not known of the stone
    iso + 10*volume                 volume of the stone [half length cubed]
    iso + 0.5*yield                 its share of rough that is given [%]; `carat`: its weight
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.measures import Measure, measures
from gemrender.reading import did_you_mean

__all__ = ["Goal", "Pose", "Scorer", "tilts_of_cone"]

#: Tilt and azimuth of the eye [deg].
Pose = tuple[float, float]
#: From a draw of the stone (0 is the stone itself) and a pose, the values of the goal's measures by name.
Scorer = Callable[[int, Pose], Mapping[str, float]]

_FACE_UP: Pose = (0.0, 0.0)
_OPERATORS: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
#: What of a stone's size goals may name, as the expression that is parsed has it: yield is a word of Python.
_SIZES = {"volume": "volume", "_yield": "yield", "carat": "carat"}
_SIMPLE = {"min": min, "max": max, "abs": abs}
_OVER_TILTS: dict[str, Callable[[Any], Any]] = {"mean": np.mean, "worst": np.min}
#: Longest goal [characters], and how deep it may be nested.
_LONGEST, _DEEPEST = 500, 20
#: Largest tilt [deg].
_MOST_TILT = 60.0
#: Azimuths of the tilts of a cone, at its edge and half-way.
_AZIMUTHS = 8


@dataclass(frozen=True, slots=True)
class Goal:
    """A goal.

    Parameters
    ----------
    text : str
        As it was written.
    measures : tuple of Measure
        The measures that it is made of.
    has_spread : bool
        Whether it needs draws of what is not known.
    tree : ast.expr
        The expression, checked.
    sizes : tuple of str
        Which of "volume", "yield" and "carat" it is made of.
    """

    text: str
    measures: tuple[Measure, ...]
    has_spread: bool
    tree: ast.expr
    sizes: tuple[str, ...] = ()

    @classmethod
    def parse(cls, text: str) -> Goal:
        """Read a goal.

        Raises
        ------
        InputError
            It is no expression of this kind, or names no measure.
        """
        if len(text) > _LONGEST:
            raise InputError(f"must have at most {_LONGEST} characters", key="goal", value=text)
        try:
            tree = ast.parse(re.sub(r"\byield\b", "_yield", text.strip()), mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise InputError("must be an expression such as iso - 0.5*leak", key="goal", value=text) from None
        found: dict[str, Measure] = {}
        spreads: list[bool] = []
        try:
            _check(tree, found, spreads, 0)
        except InputError as error:
            raise InputError(error.allowed, key="goal", value=text) from None
        used = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
        sizes = tuple(name for written, name in _SIZES.items() if written in used)
        if not found and not sizes:
            raise InputError(f"names no measure; there are {_listed()}", key="goal", value=text)
        return cls(text.strip(), tuple(found.values()), bool(spreads), tree, sizes)

    @property
    def names(self) -> tuple[str, ...]:
        """The values that it is made of: as "measure.key", and those of `sizes`."""
        return tuple(dict.fromkeys(map(_named, _leaves(self.tree))))

    @property
    def is_local(self) -> bool:
        """Whether it is of the stone itself seen from straight above: without mean, worst and spread."""
        calls = (node.func for node in ast.walk(self.tree) if isinstance(node, ast.Call))
        return all(isinstance(of, ast.Name) and of.id in _SIMPLE for of in calls)

    def partials(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return the goal's exact derivatives by each of the values that it is made of (`is_local` ones).

        Of min and max the one that counts, the first of equals, is differentiated; NaN where there is none.

        Parameters
        ----------
        values : mapping
            The values, by `names`.
        """
        names = self.names
        _, slopes = _partials(self.tree, values, {name: place for place, name in enumerate(names)})
        return dict(zip(names, slopes.tolist(), strict=True))

    def value(self, scorer: Scorer, draws: int = 0) -> float:
        """Return the goal of a stone.

        Parameters
        ----------
        scorer : callable
            What tells the measures of the stone, and of its draws 1 to `draws`; values are called
            "measure.key", and those of `sizes` by their names.
        draws : int
            Number of draws that `spread` is taken over.
        """
        value = _value(self.tree, scorer, 0, _FACE_UP, draws)
        return float(value) if math.isfinite(value) else -math.inf


def tilts_of_cone(most_deg: float) -> tuple[Pose, ...]:
    """Return the tilts that stand for a cone: none, half of it and all of it, to eight sides [deg]."""
    turns = [360.0 * number / _AZIMUTHS for number in range(_AZIMUTHS)]
    return (_FACE_UP, *((share * most_deg, turn) for share in (0.5, 1.0) for turn in turns))


def _names() -> dict[str, str]:
    """Return the values that goals may name: as written, and as "measure.key"."""
    names: dict[str, str] = {}
    keys: dict[str, list[str]] = {}
    for of in measures():
        name = of.name.replace("-", "_")
        if of.views != "one" or not of.keys:
            continue
        names[name] = f"{of.name}.{of.keys[0]}"
        for key in of.keys:
            names[f"{name}.{key}"] = f"{of.name}.{key}"
            keys.setdefault(key, []).append(f"{of.name}.{key}")
    # A key alone, where one measure has it and it is no measure's name.
    return {key: own[0] for key, own in keys.items() if len(own) == 1 and key not in names} | names


def _listed() -> str:
    """Return the measures for a message; their keys are in `gemrender measures`."""
    names = [name for name in _names() if "." not in name]
    own = [name for name in names if any(other.startswith(f"{name}.") for other in _names())]
    sizes = ", ".join(_SIZES.values())
    return f"{', '.join(own)} and their values, as aset.leak or leak (see: gemrender measures), and {sizes}"


def _check(node: ast.AST, found: dict[str, Measure], spreads: list[bool], depth: int) -> None:
    """Refuse what is no part of a goal; gather its measures."""
    if depth > _DEEPEST:
        raise InputError("is nested too deeply")
    if isinstance(node, ast.Constant):
        if (
            isinstance(node.value, bool)
            or not isinstance(node.value, (int, float))
            or not abs(node.value) < 1e9
        ):
            raise InputError("must have numbers below 1e9 only")
    elif isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
        if isinstance(node.op, ast.Pow) and not isinstance(node.right, ast.Constant):
            raise InputError("must have a number as an exponent")
        _check(node.left, found, spreads, depth + 1)
        _check(node.right, found, spreads, depth + 1)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        _check(node.operand, found, spreads, depth + 1)
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        _check_call(node, found, spreads, depth)
    elif isinstance(node, (ast.Name, ast.Attribute)):
        written = ast.unparse(node)
        if written in _SIZES:
            return
        names = _names()
        if written not in names:
            raise InputError(
                f"{written} is no value of a measure; there are {_listed()}"
                f"{did_you_mean(written, list(names))}"
            )
        name = names[written].rsplit(".", 1)[0]
        found.setdefault(name, next(of for of in measures() if of.name == name))
    else:
        raise InputError(
            "must be made of measures, numbers, + - * / **, min, max, abs, mean, worst and spread"
        )


def _check_call(node: ast.Call, found: dict[str, Measure], spreads: list[bool], depth: int) -> None:
    assert isinstance(node.func, ast.Name)
    name, arguments = node.func.id, node.args
    if name in _SIMPLE:
        if len(arguments) != 1 if name == "abs" else len(arguments) < 2:
            raise InputError(f"{name} needs {'one value' if name == 'abs' else 'two values or more'}")
        for argument in arguments:
            _check(argument, found, spreads, depth + 1)
    elif name in _OVER_TILTS:
        tilt = arguments[1].value if len(arguments) == 2 and isinstance(arguments[1], ast.Constant) else None
        if not isinstance(tilt, (int, float)) or not 0 < tilt <= _MOST_TILT:
            raise InputError(
                f"{name} needs a value and a tilt of up to {_MOST_TILT:g} degrees, as {name}(iso, 15)"
            )
        _check(arguments[0], found, spreads, depth + 1)
    elif name == "spread":
        if len(arguments) != 1:
            raise InputError("spread needs one value, as spread(iso)")
        if depth and spreads and spreads[-1]:
            raise InputError("spread cannot be taken of a spread")
        spreads.append(True)
        _check(arguments[0], found, spreads, depth + 1)
        spreads[-1] = False
    else:
        allowed = [*_SIMPLE, *_OVER_TILTS, "spread"]
        raise InputError(f"{name} is unknown; there are {', '.join(allowed)}{did_you_mean(name, allowed)}")


def _value(node: ast.AST, scorer: Scorer, drawn: int, pose: Pose, draws: int) -> float:
    if isinstance(node, ast.Constant):
        return float(node.value)  # type: ignore[arg-type]
    if isinstance(node, ast.BinOp):
        left, right = (_value(part, scorer, drawn, pose, draws) for part in (node.left, node.right))
        try:
            found = _OPERATORS[type(node.op)](left, right)
        except (ZeroDivisionError, OverflowError):
            return math.nan
        return math.nan if isinstance(found, complex) else float(found)
    if isinstance(node, ast.UnaryOp):
        value = _value(node.operand, scorer, drawn, pose, draws)
        return -value if isinstance(node.op, ast.USub) else value
    if isinstance(node, ast.Call):
        assert isinstance(node.func, ast.Name)
        name, arguments = node.func.id, node.args
        if name in _SIMPLE:
            return float(_SIMPLE[name](*(_value(part, scorer, drawn, pose, draws) for part in arguments)))  # type: ignore[operator]
        if name in _OVER_TILTS:
            assert isinstance(arguments[1], ast.Constant)
            poses = tilts_of_cone(float(arguments[1].value))  # type: ignore[arg-type]
            return float(_OVER_TILTS[name]([_value(arguments[0], scorer, drawn, at, draws) for at in poses]))
        values = [_value(arguments[0], scorer, number, pose, draws) for number in range(1, draws + 1)]
        return float(np.std(values, ddof=1)) if len(values) > 1 else 0.0
    return float(scorer(drawn, pose)[_named(node)])


def _leaves(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the parts of a goal that name values."""
    if isinstance(node, (ast.Name, ast.Attribute)):
        yield node
        return
    parts = node.args if isinstance(node, ast.Call) else list(ast.iter_child_nodes(node))
    for part in parts:
        yield from _leaves(part)


def _named(node: ast.AST) -> str:
    """Return what is named, as "measure.key", or a size's name."""
    written = ast.unparse(node)
    return _SIZES.get(written) or _names()[written]


def _partials(
    node: ast.AST, values: Mapping[str, float], places: Mapping[str, int]
) -> tuple[float, np.ndarray]:
    """Return the value of a part of a goal, and its derivatives by the values at these places, (n,)."""
    if isinstance(node, ast.Constant):
        return float(node.value), np.zeros(len(places))  # type: ignore[arg-type]
    if isinstance(node, ast.UnaryOp):
        value, slope = _partials(node.operand, values, places)
        return (-value, -slope) if isinstance(node.op, ast.USub) else (value, slope)
    if isinstance(node, ast.BinOp):
        (a, by_a), (b, by_b) = (_partials(part, values, places) for part in (node.left, node.right))
        try:
            if isinstance(node.op, ast.Pow):  # the exponent is a number
                value = a**b
                return (
                    (math.nan, by_a * math.nan)
                    if isinstance(value, complex)
                    else (value, b * a ** (b - 1.0) * by_a if b else by_b)
                )
            value = _OPERATORS[type(node.op)](a, b)
            if isinstance(node.op, ast.Mult):
                return value, b * by_a + a * by_b
            if isinstance(node.op, ast.Div):
                return value, (by_a - value * by_b) / b
            return value, by_a + by_b if isinstance(node.op, ast.Add) else by_a - by_b
        except (ZeroDivisionError, OverflowError, TypeError):
            return math.nan, np.full(len(places), math.nan)
    if isinstance(node, ast.Call):
        assert isinstance(node.func, ast.Name)
        parts = [_partials(part, values, places) for part in node.args]
        if node.func.id == "abs":
            (value, slope), *_ = parts
            return abs(value), math.copysign(1.0, value) * slope
        return (min if node.func.id == "min" else max)(parts, key=lambda part: part[0])
    name, slopes = _named(node), np.zeros(len(places))
    slopes[places[name]] = 1.0
    return float(values[name]), slopes
