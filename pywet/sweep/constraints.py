"""Constraints of a sweep: an expression of axes, such as `friction < 0.5 or angle_deg > 10`, evaluated without running code."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from pywet.errors import ConfigError, one_line

LONGEST = 500
"""Largest number of characters of an expression."""
ARITHMETIC: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv, ast.Pow: operator.pow,
}  # fmt: skip
COMPARISONS: dict[type, Callable[[Any, Any], bool]] = {
    ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge, ast.Eq: operator.eq,
    ast.NotEq: operator.ne, ast.In: lambda a, b: a in b, ast.NotIn: lambda a, b: a not in b,
}  # fmt: skip
SIGNS: dict[type, Callable[[Any], Any]] = {ast.USub: operator.neg, ast.UAdd: operator.pos, ast.Not: operator.not_}
FUNCTIONS: dict[str, Callable[..., Any]] = {
    "abs": abs, "min": min, "max": max, "sqrt": math.sqrt, "log": math.log, "log10": math.log10, "exp": math.exp,
}  # fmt: skip
EXPECTED = (
    "an expression of axes, numbers, text, + - * / **, comparisons, and, or, not, in and the functions "
    f"{', '.join(FUNCTIONS)}"
)


@dataclass(frozen=True)
class Constraint:
    """One expression; `names` are its axes by their names in the expression."""

    text: str
    tree: ast.expr
    names: Mapping[str, str]

    def holds(self, values: Mapping[str, Any]) -> bool:
        """Return whether a point satisfies the constraint; raise `ConfigError` if the expression has no value there."""
        try:
            return bool(_value(self.tree, {name: values[key] for name, key in self.names.items()}))
        except (ArithmeticError, ValueError, TypeError) as error:
            raise ConfigError(
                f"the constraint `{self.text}` has no value ({one_line(error)})",
                code="sweep.constraint_value", key="constraints", given=self.text,
            ) from error  # fmt: skip


def read(text: str, axes: list[str]) -> Constraint:
    """Parse an expression; an axis is named by its key, or by the last part of it if that is unique."""
    shown = one_line(text, 80)
    if len(text) > LONGEST:
        raise ConfigError(
            f"the constraint `{shown}` has {len(text)} characters, expected at most {LONGEST}",
            code="sweep.constraint_long", key="constraints", given=len(text), expected=LONGEST,
        )  # fmt: skip
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise ConfigError(
            f"the constraint `{shown}` is not an expression, expected {EXPECTED}",
            code="sweep.constraint_syntax", key="constraints", given=text,
        ) from error  # fmt: skip
    names: dict[str, str] = {}
    _check(tree, shown, axes, names)
    return Constraint(text, tree, names)


def _check(node: ast.AST, shown: str, axes: list[str], names: dict[str, str]) -> None:
    """Refuse syntax that expressions must not contain, and unknown axes."""
    if name := _dotted(node):
        names[name] = _axis(name, shown, axes)
        return
    inside: list[ast.AST]
    match node:
        case ast.BoolOp(values=values):
            inside = [*values]
        case ast.BinOp(left=left, op=op, right=right) if type(op) in ARITHMETIC:
            inside = [left, right]
        case ast.UnaryOp(op=op, operand=operand) if type(op) in SIGNS:
            inside = [operand]
        case ast.Compare(left=left, ops=ops, comparators=others) if all(type(op) in COMPARISONS for op in ops):
            inside = [left, *others]
        case ast.Call(func=ast.Name(id=called), args=args, keywords=[]) if called in FUNCTIONS:
            inside = [*args]
        case ast.List(elts=parts) | ast.Tuple(elts=parts):
            inside = [*parts]
        case ast.Constant(value=value) if isinstance(value, int | float | str):
            inside = []
        case _:
            raise ConfigError(
                f"the constraint `{shown}` holds `{one_line(ast.unparse(node), 60)}`, expected {EXPECTED}",
                code="sweep.constraint_word", key="constraints", given=ast.unparse(node),
            )  # fmt: skip
    for part in inside:
        _check(part, shown, axes, names)


def _dotted(node: ast.AST) -> str:
    """Return the name of an axis as written, such as `liquid.viscosity_Pa_s`; empty if the node is no name."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute) and (above := _dotted(node.value)):
        return f"{above}.{node.attr}"
    return ""


def _axis(name: str, shown: str, axes: list[str]) -> str:
    found = [axis for axis in axes if axis == name] or [axis for axis in axes if axis.endswith(f".{name}")]
    if len(found) != 1:
        what = f"{len(found)} axes end in" if found else "no axis is"
        raise ConfigError(
            f"the constraint `{shown}` names {name}, but {what} {name}; expected one of {', '.join(axes)}",
            code="sweep.constraint_name", key="constraints", given=name, expected=tuple(axes),
        )  # fmt: skip
    return found[0]


def _value(node: ast.expr, values: Mapping[str, Any]) -> Any:
    """Evaluate a checked expression; numbers are floats, so that a large power overflows instead of taking long."""
    if name := _dotted(node):
        return _number(values[name])
    match node:
        case ast.BoolOp(op=ast.And(), values=parts):
            return all(_value(part, values) for part in parts)
        case ast.BoolOp(values=parts):
            return any(_value(part, values) for part in parts)
        case ast.BinOp(left=left, op=op, right=right):
            return ARITHMETIC[type(op)](_value(left, values), _value(right, values))
        case ast.UnaryOp(op=op, operand=operand):
            return SIGNS[type(op)](_value(operand, values))
        case ast.Compare(left=left, ops=ops, comparators=others):
            sides = [_value(side, values) for side in (left, *others)]
            return all(COMPARISONS[type(op)](a, b) for op, a, b in zip(ops, sides, sides[1:], strict=False))
        case ast.Call(func=ast.Name(id=called), args=args):
            return FUNCTIONS[called](*(_value(arg, values) for arg in args))
        case ast.List(elts=parts) | ast.Tuple(elts=parts):
            return [_value(part, values) for part in parts]
        case ast.Constant(value=value):
            return _number(value)
    raise TypeError(type(node).__name__)  # `_check` lets nothing else through


def _number(value: Any) -> Any:
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else value
