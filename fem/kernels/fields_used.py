"""Fields of its arguments that a part uses, itself or in parts that it calls: all that its code depends on.

Found in the text of functions. Where it is not plain what becomes of a value, all of it counts as used.
"""

import ast
import inspect
from collections.abc import Callable, Iterator
from functools import cache, reduce
from pathlib import Path

WHOLE = None  # of a value: all of it
Used = dict[str, "Used"] | None  # fields, each with what is used of it; no field: the type alone, or whether it is None

callees: dict[Callable, Callable[[], list[Callable]]] = {}  # the functions that may be a part's code
shifted: dict[Callable, Callable] = {}  # of `jit.every`: the part that it calls with all arguments but the first


def merged(one: Used, other: Used) -> Used:
    """All that either uses."""
    if one is WHOLE or other is WHOLE:
        return WHOLE
    return {name: merged(one.get(name, {}), other.get(name, {})) for name in {**one, **other}}


@cache
def fields_used(function: Callable) -> tuple[Used, ...]:
    """What is used of each parameter."""
    if function in shifted:
        return WHOLE, *_of_call(shifted[function])[1:]
    used = _Reader(function).used
    return tuple(used[name] for name in inspect.signature(function).parameters)


@cache
def _of_call(function: Callable) -> tuple[Used, ...]:
    """The same of a call of a part, whose code is chosen by types."""
    found = [fields_used(code) for code in callees[function]()]
    return tuple(reduce(merged, each) for each in zip(*found, strict=True))


def forget() -> None:
    """Read functions anew: a part has got code for one more type."""
    fields_used.cache_clear()
    _of_call.cache_clear()


@cache
def _functions(path: str) -> dict[int, ast.FunctionDef]:
    """Functions of a module by the line on which they or their decorators begin."""
    nodes = [n for n in ast.walk(ast.parse(Path(path).read_text(encoding="utf-8"))) if isinstance(n, ast.FunctionDef)]
    return {min([n.lineno, *(d.lineno for d in n.decorator_list)]): n for n in nodes}


class _Reader(ast.NodeVisitor):
    """What a function uses of its parameters."""

    def __init__(self, function: Callable):
        node = _functions(function.__code__.co_filename)[function.__code__.co_firstlineno]
        names = inspect.signature(function).parameters
        self.globals, self.used = function.__globals__, {name: {} for name in names}
        self.paths: dict[str, list[tuple[str, ...]]] = {name: [(name,)] for name in names}
        found = -1
        while found != (found := sum(map(len, self.paths.values()))):  # names for fields of names for fields
            for each in ast.walk(node):
                if isinstance(each, ast.Assign):
                    self._name(each)
        for statement in node.body:
            self.visit(statement)

    def _name(self, assign: ast.Assign) -> None:
        """Take note of names that an assignment gives to fields."""
        for target, value in _pairs(assign):
            if isinstance(target, ast.Name) and target.id != _root(value):
                known = self.paths.setdefault(target.id, []) if (new := self._paths(value)) else []
                known.extend(path for path in new if path not in known)

    def _paths(self, node: ast.expr) -> list[tuple[str, ...]]:
        """The fields that an expression may be, as a parameter's name and names of fields; none: something else."""
        if isinstance(node, ast.Name):
            return self.paths.get(node.id, [])
        if isinstance(node, ast.Attribute):
            return [(*path, node.attr) for path in self._paths(node.value)]
        return []

    def _use(self, node: ast.expr, what: Used) -> None:
        for name, *fields in self._paths(node):
            used = what
            for field in reversed(fields):
                used = {field: used}
            self.used[name] = merged(self.used[name], used)

    def visit_Assign(self, node: ast.Assign) -> None:
        for target, value in _pairs(node):
            named = isinstance(target, ast.Name)
            if not named:
                self.visit(target)
            if not (named and target.id != _root(value) and self._paths(value)):
                self.visit(value)

    def visit_Name(self, node: ast.Name) -> None:
        self._use(node, WHOLE)

    def visit_Attribute(self, node: ast.Attribute) -> None:
        if self._paths(node):
            self._use(node, WHOLE)
        else:
            self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        if self._paths(node.left) and all(isinstance(op, (ast.Is, ast.IsNot)) for op in node.ops):
            self._use(node.left, {})
            for other in node.comparators:
                self.visit(other)
        else:
            self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        called = self.globals.get(node.func.id) if isinstance(node.func, ast.Name) else None
        known = callable(called) and called in callees and node.func.id not in self.paths
        if not known or node.keywords or any(isinstance(a, ast.Starred) for a in node.args):
            self.generic_visit(node)
            return
        for argument, what in zip(node.args, _of_call(called), strict=False):  # others have defaults
            if self._paths(argument):
                self._use(argument, what)
            else:
                self.visit(argument)


def _pairs(assign: ast.Assign) -> Iterator[tuple[ast.expr, ast.expr]]:
    """Targets and values of an assignment, those of tuples one by one."""
    value = assign.value
    for target in assign.targets:
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple) and len(target.elts) == len(value.elts):
            yield from zip(target.elts, value.elts, strict=True)
        else:
            yield target, value


def _root(node: ast.expr) -> str | None:
    while isinstance(node, ast.Attribute):
        node = node.value
    return node.id if isinstance(node, ast.Name) else None
