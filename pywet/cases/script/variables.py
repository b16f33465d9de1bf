"""Variables of a LIGGGHTS script whose values its text determines: numbers, words, arithmetic of both; no loops."""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Sequence

NAME = re.compile(r"\$(?:\{(\w+)\}|(\w))")
OPERATORS: dict[type, Callable[..., float]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv, ast.Pow: operator.pow,
    ast.USub: operator.neg, ast.UAdd: operator.pos,
}  # fmt: skip


class Variables:
    """Values by name; those of the command line (`-var NAME VALUE`) take precedence."""

    def __init__(self, words: Sequence[str] = ()) -> None:
        at = [k for k, word in enumerate(words[:-2]) if word in ("-var", "-v")]
        self._given = {words[k + 1]: words[k + 2] for k in at}
        self._values = dict(self._given)
        self._doubted: set[str] = set()

    def filled(self, words: list[str]) -> list[str]:
        """Replace variables by their values; undefined ones are left as they are."""
        return [NAME.sub(lambda m: self._values.get(m[1] or m[2], m[0]), word) for word in words]

    def learn(self, words: list[str]) -> None:
        """Evaluate the command `variable NAME STYLE VALUE …`; the value is unknown for unsupported styles."""
        match words:
            case ["variable", name, "delete"]:
                self._values.pop(name, None)
            case ["variable", name, "index", first, *_] if name not in self._doubted:
                self._values.setdefault(name, first)
            case ["variable", name, "string", value, *_]:
                self._values[name] = self._given.get(name, value)
            case ["variable", name, "equal", *formula]:
                if (number := self._number(" ".join(formula))) is None:
                    self._values.pop(name, None)
                else:
                    self._values[name] = f"{number:.15g}"
            case ["variable", name, *_]:
                self._values.pop(name, None)
            case ["next", *names]:
                self._forget(*names)

    def doubt(self, words: list[str]) -> None:
        """Forget the variables that a command would set which the engine executes in some cases only, such as one within `if`."""
        match words:
            case ["variable", name, "index", *_] if name in self._values:
                pass  # the engine leaves an existing one as it is
            case ["variable", name, "string", *_] if name in self._given:
                pass
            case ["variable", name, *_]:
                self._forget(name)
            case ["next", *names]:
                self._forget(*names)

    def _forget(self, *names: str) -> None:
        self._doubted.update(names)
        for name in names:
            self._values.pop(name, None)

    def _number(self, formula: str) -> float | None:
        text = re.sub(r"\bv_(\w+)", lambda m: f"({self._values.get(m[1], 'unknown')})", formula).replace("^", "**")
        try:
            return _value(ast.parse(text.strip(), mode="eval").body)
        except (SyntaxError, ValueError, TypeError, ArithmeticError, RecursionError):
            return None


def _value(node: ast.expr) -> float:
    match node:
        case ast.Constant(value=int() | float() as value):
            return float(value)
        # the engine goes from left to right, and a sign binds more tightly than a power; Python does the opposite
        case ast.BinOp(_, ast.Pow(), ast.BinOp(_, ast.Pow(), _)) | ast.UnaryOp(_, ast.BinOp(_, ast.Pow(), _)):
            raise ValueError("expected brackets")
        case ast.BinOp(left, op, right) if type(op) in OPERATORS:
            return float(OPERATORS[type(op)](_value(left), _value(right)))
        case ast.UnaryOp(op, operand) if type(op) in OPERATORS:
            return float(OPERATORS[type(op)](_value(operand)))
    raise ValueError("expected numbers and + - * / ^")
