"""The operators of mutation: what else an expression could have been.

The set is that of R. A. DeMillo and A. J. Offutt (1991), "Constraint-based automatic test data generation", as far as
Python has it: relations, logic, arithmetic, constants; and the ends of slices, min and max, and limits by name.
"""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterator, Mapping

#: Each relation, and what replaces it: first the neighbour at the boundary, then the opposite.
RELATIONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.FloorDiv,
    ast.FloorDiv: ast.Mult,
    ast.Div: ast.Mult,
    ast.Mod: ast.FloorDiv,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
}
#: Functions and methods that take each other's place.
TWINS = {"min": "max", "any": "all", "minimum": "maximum", "floor": "ceil"}
TWINS |= {twin: name for name, twin in TWINS.items()}


def alternatives(node: ast.expr, limits: Mapping[str, type]) -> Iterator[ast.expr]:
    """Yield what may replace an expression; `limits` has the names of numbers that are limits, and their types."""
    match node:
        case ast.Compare():
            yield from _relations(node)
        case ast.BoolOp(op=op, values=values):
            yield ast.BoolOp(ast.And() if isinstance(op, ast.Or) else ast.Or(), values)
            for i in range(len(values)):
                rest = values[:i] + values[i + 1 :]
                yield rest[0] if len(rest) == 1 else ast.BoolOp(op, rest)
        case ast.UnaryOp(op=ast.Not() | ast.Invert(), operand=operand):
            yield operand
        case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=int(value) | float(value))):
            yield from map(ast.Constant, _numbers(-value))
        case ast.BinOp(left=left, op=op, right=right) if type(op) in ARITHMETIC and not (
            _is_text(left) or _is_text(right)
        ):
            yield ast.BinOp(left, ARITHMETIC[type(op)](), right)
        case ast.Constant(value=bool(value)):
            yield ast.Constant(not value)
        case ast.Constant(value=int(value) | float(value)):
            yield from map(ast.Constant, _numbers(value))
        case ast.Call(func=ast.Name(id=name)) if name in TWINS:
            yield ast.Call(ast.Name(TWINS[name], ast.Load()), node.args, node.keywords)
        case ast.Call(func=ast.Attribute(value=of, attr=name)) if name in TWINS:
            yield ast.Call(ast.Attribute(of, TWINS[name], ast.Load()), node.args, node.keywords)
        case ast.Name(id=name, ctx=ast.Load()) | ast.Attribute(attr=name, ctx=ast.Load()) if name in limits:
            yield ast.BinOp(node, ast.Mult(), ast.Constant(2))
            if limits[name] is int:
                yield ast.BinOp(node, ast.Add(), ast.Constant(1))
                yield ast.BinOp(node, ast.Sub(), ast.Constant(1))
            else:
                yield ast.BinOp(node, ast.Div(), ast.Constant(2))


def slice_end(node: ast.expr, is_upper: bool) -> Iterator[ast.expr]:
    """Yield the end of a slice, moved inwards by one; ends with a number or arithmetic have mutants of their own."""
    if isinstance(node, ast.Name | ast.Attribute | ast.Call):
        yield ast.BinOp(node, ast.Sub() if is_upper else ast.Add(), ast.Constant(1))


def negation(node: ast.expr) -> Iterator[ast.expr]:
    """Yield the opposite of a condition, if none of `alternatives` is that."""
    if not isinstance(node, ast.Compare | ast.BoolOp | ast.UnaryOp | ast.Constant):
        yield ast.UnaryOp(ast.Not(), node)


def copied(node: ast.expr) -> ast.expr:
    """Return an expression that shares no node with any other."""
    return copy.deepcopy(node)


def _relations(node: ast.Compare) -> Iterator[ast.expr]:
    for i, op in enumerate(node.ops):
        for other in RELATIONS[type(op)]:
            yield ast.Compare(node.left, [*node.ops[:i], other(), *node.ops[i + 1 :]], node.comparators)


def _numbers(value: float) -> tuple[float, ...]:
    return (value + 1, value - 1) if isinstance(value, int) else (value * 2 or 1.0,)


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str | bytes))
