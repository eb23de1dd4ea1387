"""Conditions of a specification: a small language of comparisons and arithmetic.

    path.draw_speed * control.normal_force <= 1 and canvas.kind == 'bowl'

Names are settings, axes or metrics, dots included. There are numbers, strings, true, false, null,
+ - * / **, comparisons, `in` with a list, and, or, not, abs, min, max, sqrt. Nothing else is
evaluated: a specification can be read without trusting it. Arithmetic is that of numbers of 64
bits, so neither a power of powers nor a text times a number grows beyond them.
"""

import ast
import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

_ARITHMETIC: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
_COMPARISONS: dict[type, Callable[[Any, Any], bool]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.In: lambda a, b: a in b,
    ast.NotIn: lambda a, b: a not in b,
}
_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "abs": abs, "min": min, "max": max, "sqrt": math.sqrt,
}
_DEEPEST = 100
_WORDS = {"true": True, "false": False, "null": None}


class Expression:
    """A condition, checked once, evaluated often. Raises ValueError if it is not one."""

    def __init__(self, text: str) -> None:
        self.text = text
        if len(text) > 2000:
            raise ValueError("longer than 2000 characters")
        try:
            self._tree = ast.parse(text.strip(), mode="eval").body
            self.names: set[str] = set()
            self._check(self._tree)
        except (SyntaxError, MemoryError, RecursionError):
            raise ValueError(f"'{text}' is no condition") from None

    def __call__(self, values: Mapping[str, Any]) -> Any:
        """The value; a comparison with null is false. Raises ValueError."""
        try:
            return self._value(self._tree, values)
        except OverflowError:
            raise ValueError(f"'{self.text}': a number beyond 64 bits") from None
        except (ArithmeticError, TypeError, ValueError) as error:
            raise ValueError(f"'{self.text}': {error}") from None

    def _check(self, node: ast.AST, depth: int = 0) -> None:
        if depth > _DEEPEST:
            raise ValueError(f"nested more than {_DEEPEST} deep")
        if (name := _dotted(node)) is not None:
            if name not in _WORDS:
                self.names.add(name)
            return
        match node:
            case ast.Constant(value=bool() | int() | float() | str()):
                return
            case ast.BinOp(left=a, op=op, right=b) if type(op) in _ARITHMETIC:
                parts: list[ast.AST] = [a, b]
            case ast.UnaryOp(op=ast.USub() | ast.Not(), operand=a):
                parts = [a]
            case ast.BoolOp(values=values):
                parts = list(values)
            case ast.Compare(left=a, ops=ops, comparators=rest) if all(
                type(op) in _COMPARISONS for op in ops
            ):
                parts = [a, *rest]
            case ast.Call(func=ast.Name(id=f), args=args, keywords=[]) if f in _FUNCTIONS:
                parts = list(args)
            case ast.List(elts=elements) | ast.Tuple(elts=elements):
                parts = list(elements)
            case _:
                raise ValueError(f"'{ast.unparse(node)}' has no meaning in a condition")
        for part in parts:
            self._check(part, depth + 1)

    def _value(self, node: ast.AST, values: Mapping[str, Any]) -> Any:
        if (name := _dotted(node)) is not None:
            if name in _WORDS:
                return _WORDS[name]
            if name not in values:
                raise ValueError(f"{name} has no value here")
            return values[name]
        match node:
            case ast.Constant(value=value):
                return value
            case ast.BinOp(left=a, op=op, right=b):
                left, right = self._value(a, values), self._value(b, values)
                if left is None or right is None:
                    return None
                result = _ARITHMETIC[type(op)](_number(left), _number(right))
                if isinstance(result, complex):
                    raise ValueError("a root of a number below 0")
                return result
            case ast.UnaryOp(op=ast.Not(), operand=a):
                return not self._value(a, values)
            case ast.UnaryOp(operand=a):
                value = self._value(a, values)
                return None if value is None else -_number(value)
            case ast.BoolOp(op=ast.And(), values=parts):
                return all(self._value(p, values) for p in parts)
            case ast.BoolOp(values=parts):
                return any(self._value(p, values) for p in parts)
            case ast.Compare(left=a, ops=ops, comparators=rest):
                left = self._value(a, values)
                for op, part in zip(ops, rest):
                    right = self._value(part, values)
                    if not _compare(op, left, right):
                        return False
                    left = right
                return True
            case ast.Call(func=ast.Name(id=f), args=args):
                return _FUNCTIONS[f](*(self._value(a, values) for a in args))
            case ast.List(elts=elements) | ast.Tuple(elts=elements):
                return [self._value(e, values) for e in elements]
        raise AssertionError(node)


def _number(value: Any) -> float:
    if not isinstance(value, (bool, int, float)):
        raise TypeError("arithmetic is for numbers")
    return float(value)


def _compare(op: ast.cmpop, left: Any, right: Any) -> bool:
    if isinstance(op, (ast.Lt, ast.LtE, ast.Gt, ast.GtE)) and (left is None or right is None):
        return False
    return bool(_COMPARISONS[type(op)](left, right))


def _dotted(node: ast.AST) -> str | None:
    """The text of a.b.c; None if the node is something else."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute) and (head := _dotted(node.value)) is not None:
        return f"{head}.{node.attr}"
    return None
