"""A Python module with all of its mutants behind one switch.

Mutant schemata are those of R. H. Untch, A. J. Offutt and M. J. Harrold (1993), "Mutation analysis using mutant
schemata". An expression `E` with the mutants 7 and 8 becomes ``(E7 if is_on(7) else E8) if at(7, 8) else E``, where
E7 and E8 have no choices inside. Only code that runs in functions is mutated: the switch is set after the import.
What makes the text of an error is left alone, and so is progress.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from .mutant import Mutant
from .python_operators import alternatives, copied, negation, slice_end

#: The name by which a mutated module knows the switch.
SWITCH = "_mutation_switch"

#: Calls whose arguments are a text or progress.
TEXT_CALLS = {"error", "warn", "warn_caller", "printable", "counted", "kind_of", "list_rows", "name_rows"}
PROGRESS_CALLS = {"advance", "progress", "callback"}
LONGEST = 100


def schemata(
    tree: ast.Module, file: str, first: int, limits: Mapping[str, type], *, refusals_only: bool
) -> list[Mutant]:
    """Put choices into the tree of a module; return its mutants, numbered from `first`.

    With `refusals_only` only functions that raise something are changed.
    """
    choices = _Choices(file, first, limits, refusals_only)
    choices.visit(tree)
    ast.fix_missing_locations(tree)
    return choices.mutants


def numeric_limits(tree: ast.Module) -> dict[str, type]:
    """Return the names of constants at the top of a module that are numbers, and whether these are int or float."""
    found: dict[str, type] = {}
    for node in tree.body:
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                pairs = [(name, value)]
            case ast.Assign(targets=[ast.Tuple(elts=names)], value=ast.Tuple(elts=values)):
                pairs = [(ast.unparse(name), value) for name, value in zip(names, values, strict=True)]
            case _:
                continue
        found |= {name: kind for name, value in pairs if name.isupper() for kind in _kinds(value)}
    return found


class _Choices(ast.NodeTransformer):
    """Replaces expressions and statements by choices among themselves and their mutants."""

    def __init__(self, file: str, first: int, limits: Mapping[str, type], refusals_only: bool) -> None:
        self.file, self.limits, self.refusals_only = file, limits, refusals_only
        self.next = first
        self.mutants: list[Mutant] = []
        self.scope: list[str] = []

    # Expressions: make the mutants of the whole, then of its parts, then the choice.

    def visit(self, node: ast.AST) -> Any:
        return self._expression(node) if isinstance(node, ast.expr) else super().visit(node)

    def _expression(self, node: ast.expr, more: Iterable[ast.expr] = ()) -> ast.expr:
        others = [copied(other) for other in (*more, *alternatives(node, self.limits))]
        first = self.next
        numbers = [self._add(node.lineno, ast.unparse(node), ast.unparse(other)) for other in others]
        self._parts(node)
        if not others:
            return node
        chosen = others[-1]
        for number, other in zip(numbers[-2::-1], others[-2::-1], strict=True):
            chosen = ast.IfExp(_call("is_on", number), other, chosen)
        return ast.copy_location(ast.IfExp(_call("at", first, numbers[-1]), chosen, node), node)

    def _parts(self, node: ast.expr) -> None:
        match node:
            case ast.JoinedStr() | ast.UnaryOp(op=ast.USub(), operand=ast.Constant()):
                return
            case ast.Call() if _called(node) in TEXT_CALLS or _called(node).endswith("Error"):
                return
            case ast.Call(func=ast.Name(id="isinstance"), args=[what, *_]):
                node.args[0] = self._expression(what)
            case ast.Lambda():
                node.body = self._expression(node.body)
            case ast.IfExp():
                node.test = self._condition(node.test)
                node.body, node.orelse = self._expression(node.body), self._expression(node.orelse)
            case ast.Slice():
                for name in ("lower", "upper"):
                    if (end := getattr(node, name)) is not None:
                        setattr(node, name, self._expression(end, slice_end(end, name == "upper")))
            case _:
                self.generic_visit(node)

    def _condition(self, node: ast.expr, more: Iterable[ast.expr] = ()) -> ast.expr:
        return self._expression(node, (*more, *negation(node)))

    def visit_comprehension(self, node: ast.comprehension) -> ast.AST:
        node.iter = self._expression(node.iter)
        node.ifs = [self._condition(test) for test in node.ifs]
        return node

    # Only code in functions is changed.

    def visit_Module(self, node: ast.Module) -> ast.AST:
        for part in node.body:
            if isinstance(part, ast.FunctionDef | ast.ClassDef):
                self.visit(part)
        return node

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        self.scope.append(node.name)
        for part in node.body:
            if isinstance(part, ast.FunctionDef | ast.ClassDef):
                self.visit(part)
        self.scope.pop()
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        raises = any(isinstance(part, ast.Raise) for part in ast.walk(node))
        if _makes_text(node, raises) or (self.refusals_only and not raises):
            return node
        self.scope.append(node.name)
        node.body = self._block(node.body)
        self.scope.pop()
        return node

    # Statements.

    def _block(self, body: list[ast.stmt], *, is_guarded: bool = False) -> list[ast.stmt]:
        """Change statements, but neither what an error is made of, nor the error of a guard, whose test is changed."""
        if not isinstance(body[-1], ast.Raise):
            return [self._statement(part) for part in body]
        before = [part if isinstance(part, ast.Assign) else self._statement(part) for part in body[:-1]]
        return [*before, body[-1] if is_guarded else self._statement(body[-1])]

    def _statement(self, node: ast.stmt) -> ast.stmt:
        match node:
            case ast.Raise():
                return node if "NotImplemented" in ast.unparse(node) else self._removable(node)
            case ast.Expr(value=ast.Call() as call):
                if _called(call) in PROGRESS_CALLS:
                    return node
                whole = self._removable_number(node)
                self._parts(call)
                return self._unless(whole, node)
            case ast.AugAssign(op=op) if isinstance(op, ast.Add | ast.Sub):
                opposite = ast.AugAssign(node.target, ast.Sub() if isinstance(op, ast.Add) else ast.Add(), node.value)
                other = ast.parse(ast.unparse(opposite)).body[0]
                number = self._add(node.lineno, ast.unparse(node), ast.unparse(other))
                node.value = self._expression(node.value)
                return ast.copy_location(ast.If(_call("at", number, number), [other], [node]), node)
            case ast.If():
                return self._if(node)
            case ast.While():
                node.test = self._condition(node.test)
                node.body, node.orelse = self._block(node.body), self._block(node.orelse) if node.orelse else []
                return node
            case ast.AnnAssign():
                node.value = node.value and self._expression(node.value)
                return node
            case ast.Assert() | ast.Import() | ast.ImportFrom() | ast.Expr(value=ast.Constant()):
                return node
            case _:
                return self._compound(node)

    def _compound(self, node: ast.stmt) -> ast.stmt:
        """Change the blocks and the expressions of any other statement."""
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            self.visit(node)
            return node
        for name, value in ast.iter_fields(node):
            if isinstance(value, ast.expr):
                setattr(node, name, self._expression(value))
            elif isinstance(value, list) and value and isinstance(value[0], ast.stmt):
                setattr(node, name, self._block(value))
            elif isinstance(value, list):
                for part in value:
                    self._part_of_statement(part)
        return node

    def _part_of_statement(self, part: object) -> None:
        if isinstance(part, ast.ExceptHandler):
            part.body = self._block(part.body)
        elif isinstance(part, ast.match_case):
            part.guard = part.guard and self._condition(part.guard)
            part.body = self._block(part.body)
        elif isinstance(part, ast.withitem):
            part.context_expr = self._expression(part.context_expr)
        elif isinstance(part, ast.expr):  # targets
            self._parts(part)

    def _if(self, node: ast.If) -> ast.stmt:
        refuses = isinstance(node.body[-1], ast.Raise)
        node.test = self._condition(node.test, [ast.Constant(False)] if refuses else [])
        node.body = self._block(node.body, is_guarded=refuses)
        node.orelse = self._block(node.orelse) if node.orelse else []
        return node

    def _removable_number(self, node: ast.stmt) -> int:
        return self._add(node.lineno, ast.unparse(node), "pass")

    def _removable(self, node: ast.stmt) -> ast.stmt:
        return self._unless(self._removable_number(node), node)

    def _unless(self, number: int, node: ast.stmt) -> ast.stmt:
        return ast.copy_location(ast.If(ast.UnaryOp(ast.Not(), _call("at", number, number)), [node], []), node)

    def _add(self, line: int, original: str, replacement: str) -> int:
        old, new = (text if len(text) <= LONGEST else f"{text[:LONGEST]}…" for text in (original, replacement))
        self.mutants.append(Mutant(self.next, self.file, line, ".".join(self.scope), old, new))
        self.next += 1
        return self.next - 1


def _makes_text(node: ast.FunctionDef, raises: bool) -> bool:
    """Return whether a function makes a text or an error, and refuses nothing."""
    returns = ast.unparse(node.returns) if node.returns else ""
    return not raises and (returns in ("str", "list[str]", "str | None") or returns.endswith("Error"))


def _called(node: ast.Call) -> str:
    """Return the name of the function or method that is called."""
    return str(getattr(node.func, "attr", getattr(node.func, "id", "")))


def _kinds(node: ast.expr) -> Iterator[type]:
    """Yield int or float if an expression is made of numbers alone."""
    allowed = (ast.Constant, ast.BinOp, ast.UnaryOp, ast.operator, ast.unaryop)
    constants = [part.value for part in ast.walk(node) if isinstance(part, ast.Constant)]
    is_number = all(isinstance(value, int | float) and not isinstance(value, bool) for value in constants)
    if is_number and all(isinstance(part, allowed) for part in ast.walk(node)):
        yield float if any(isinstance(value, float) for value in constants) else int


def _call(name: str, *numbers: int) -> ast.expr:
    """Return a call of the switch."""
    switch = ast.Attribute(ast.Name(SWITCH, ast.Load()), name, ast.Load())
    return ast.Call(switch, [ast.Constant(number) for number in numbers], [])
