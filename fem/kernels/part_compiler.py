"""What the code of a part depends on: the fields that it uses, and branches that types decide.

Fields that a part uses, itself or in parts that it calls, are all that its code depends on: found in the text of
functions (`fields_used`). Where it is not plain what becomes of a value, all of it counts as used.

A pass of numba's compiler leaves out branches that types decide (`KnownTypes`). Numba prunes `if argument is None`
itself. Here what is asked may be a field of an argument that is a named tuple, at any depth, an entry of a tuple, or a
name that is given to one of these, in branches too if all of them agree; and `isinstance(argument, Kind)` may ask of
which named tuple it is. So one function serves scenes with a part and without it, and bodies of several kinds. What
numba then cannot type (results of calls, `== None`, `if x.a:`) ends in a TypingError, never in the wrong branch.
"""

import ast
import inspect
import operator
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from types import ModuleType

from numba import types
from numba.extending import lower_cast, models, register_model

from fem.kernels import numba_private as private
from fem.kernels.numba_private import ir

WHOLE = None  # of a value: all of it
Used = dict[str, "Used"] | None  # fields, each with what is used of it; no field: the type alone, or whether it is None

callees: dict[Callable, Callable] = {}  # the functions that are parts' code
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
        return WHOLE, *fields_used(callees[shifted[function]])[1:]
    return tuple(_Reader(function).used.values())


@cache
def _functions(path: str) -> dict[int, ast.FunctionDef]:
    """Functions of a module by the line on which they or their decorators begin."""
    nodes = [n for n in ast.walk(ast.parse(Path(path).read_text(encoding="utf-8"))) if isinstance(n, ast.FunctionDef)]
    return {min([n.lineno, *(d.lineno for d in n.decorator_list)]): n for n in nodes}


class _Reader(ast.NodeVisitor):
    """What a function uses of its parameters."""

    def __init__(self, function: Callable):
        node = _functions(function.__code__.co_filename)[function.__code__.co_firstlineno]
        names, found = inspect.signature(function).parameters, -1
        self.globals, self.used = function.__globals__, {name: {} for name in names}
        self.paths: dict[str, set[tuple[str, ...]]] = {name: {(name,)} for name in names}
        while found != (found := sum(map(len, self.paths.values()))):  # names for fields of names for fields
            for target, value in (pair for each in ast.walk(node) for pair in _pairs(each)):
                if new := self._renamed(target, value):
                    self.paths.setdefault(target.id, set()).update(new)
        for statement in node.body:
            self.visit(statement)

    def _paths(self, node: ast.expr) -> set[tuple[str, ...]]:
        """The fields that an expression may be, as a parameter's name and names of fields; none: something else."""
        if isinstance(node, ast.Name):
            return self.paths.get(node.id, set())
        return {(*path, node.attr) for path in self._paths(node.value)} if isinstance(node, ast.Attribute) else set()

    def _renamed(self, target: ast.expr, value: ast.expr) -> set[tuple[str, ...]]:
        """The fields that an assignment gives a name to."""
        return self._paths(value) if isinstance(target, ast.Name) and target.id != _root(value) else set()

    def _use(self, node: ast.expr, what: Used) -> None:
        for name, *fields in self._paths(node):
            used = what
            for field in reversed(fields):
                used = {field: used}
            self.used[name] = merged(self.used[name], used)

    def visit_Assign(self, node: ast.Assign) -> None:
        for target, value in _pairs(node):
            if not isinstance(target, ast.Name):
                self.visit(target)
            if not self._renamed(target, value):
                self.visit(value)

    def visit_Attribute(self, node: ast.expr) -> None:
        if self._paths(node):
            self._use(node, WHOLE)
        else:
            self.generic_visit(node)

    visit_Name = visit_Attribute

    def visit_Compare(self, node: ast.Compare) -> None:
        if self._paths(node.left) and all(isinstance(op, (ast.Is, ast.IsNot)) for op in node.ops):
            self._use(node.left, {})
            for other in node.comparators:
                self.visit(other)
        else:
            self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        name, called = _root(node.func), None
        if name == "isinstance":
            self._use(node.args[0], {})
            return
        if name not in self.paths:
            called = self.globals.get(name)
            if isinstance(called, ModuleType) and isinstance(node.func, ast.Attribute):
                called = getattr(called, node.func.attr, None)
        known = callable(called) and called in callees
        if not known or node.keywords or any(isinstance(a, ast.Starred) for a in node.args):
            self.generic_visit(node)
            return
        for argument, what in zip(node.args, fields_used(callees[called]), strict=False):  # others have defaults
            if self._paths(argument):
                self._use(argument, what)
            else:
                self.visit(argument)


def _pairs(assign: ast.AST) -> Iterator[tuple[ast.expr, ast.expr]]:
    """Targets and values of an assignment, those of tuples one by one; none of anything else."""
    value = getattr(assign, "value", None)
    for target in assign.targets if isinstance(assign, ast.Assign) else ():
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple) and len(target.elts) == len(value.elts):
            yield from zip(target.elts, value.elts, strict=True)
        else:
            yield target, value


def _root(node: ast.expr) -> str | None:
    while isinstance(node, ast.Attribute):
        node = node.value
    return node.id if isinstance(node, ast.Name) else None


# fields that are not used have a type of their own


class UnusedType(types.Type):
    """Numba type of a field that a part does not use: see `fields_used`."""


UNUSED = UnusedType("unused")


@register_model(UnusedType)
class _UnusedModel(models.StructModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, [])


def narrowed(given: types.Type, used: Used) -> types.Type:
    """The type with all fields unused but some."""
    if used is WHOLE or not isinstance(given, types.BaseNamedTuple):
        return given
    kinds = [narrowed(t, used[f]) if f in used else UNUSED for f, t in zip(given.fields, given, strict=True)]
    return types.BaseTuple.from_types(kinds, given.instance_class)


@lower_cast(types.Any, UnusedType)
def _leave_out(context, builder, given, wanted, value):
    return context.get_constant_undef(wanted)


@lower_cast(types.BaseNamedTuple, types.BaseNamedTuple)
def _narrow(context, builder, given, wanted, value):
    narrow = context.get_constant_undef(wanted)
    for i, kinds in enumerate(zip(given, wanted, strict=True)):
        if kinds[1] != UNUSED:
            field = context.cast(builder, builder.extract_value(value, i), *kinds)
            narrow = builder.insert_value(narrow, field, i)
    return narrow


# branches that types decide


DEEPEST = 16  # of names for names
SOMETHING = types.pyobject  # the type of what is not None, where no more is known


@private.register_pass(mutates_CFG=True, analysis_only=False)
class KnownTypes(private.FunctionPass):
    """Questions that types answer become constants, branches are pruned."""

    _name = "known_types"

    def __init__(self):
        super().__init__()

    def run_pass(self, state) -> bool:
        code, changed = state.func_ir, False
        while _Known(code, state.args).decide():  # a pruned branch may leave a name with one value
            private.dead_branch_prune(code, state.args)
            code._definitions = private.build_definitions(code.blocks)
            code._consts = private.consts.ConstantInference(code)
            changed = True
        return changed


class KernelCompiler(private.CompilerBase):
    """Numba's own compiler with this pass."""

    def define_pipelines(self):
        manager = private.DefaultPassBuilder.define_nopython_pipeline(self.state)
        manager.add_pass_after(KnownTypes, private.DeadBranchPrune)
        manager.finalize()
        return [manager]


class _Known:
    """What the types of arguments tell of a function's variables."""

    def __init__(self, code: ir.FunctionIR, arguments: tuple):
        self.code, self.arguments = code, arguments

    def decide(self) -> bool:
        """Put constants in place of questions that types answer; whether there are any."""
        decided = False
        for block in self.code.blocks.values():
            for statement in block.find_insts(ir.Assign):
                value = statement.value
                answer = self.answer(value) if isinstance(value, ir.Expr) else None
                if answer is not None:
                    statement.value = ir.Const(answer, value.loc)
                    definitions = self.code._definitions[statement.target.name]
                    definitions[definitions.index(value)] = statement.value
                    decided = True
        return decided

    def answer(self, value: ir.Expr) -> bool | None:
        """To `x is None`, `x is not None` or `isinstance(x, Kind)`; None: types tell nothing, or it is no such."""
        if value.op == "binop" and value.fn in (operator.is_, operator.is_not):
            one, other = self.is_none(value.lhs), self.is_none(value.rhs)
            if None in (one, other) or not (one or other):  # unknown, or neither is None
                return None
            return (one == other) == (value.fn is operator.is_)
        if value.op != "call" or len(value.args) != 2:
            return None
        called, kind = ([d.value for d in self.definitions(v) if isinstance(d, ir.Global)]
                        for v in (value.func, value.args[1]))  # fmt: skip
        given = self.kinds(value.args[0])
        if called != [isinstance] or len(kind) != 1 or len(given) != 1 or given[0] is None:
            return None
        return getattr(given[0], "instance_class", None) is kind[0]

    def is_none(self, variable: ir.Var) -> bool | None:
        """In all that may define it; None: nobody knows."""
        answers = {None if kind is None or isinstance(kind, types.Optional) else isinstance(kind, types.NoneType)
                   for kind in self.kinds(variable)}  # fmt: skip
        return answers.pop() if len(answers) == 1 else None

    def definitions(self, variable: ir.Var) -> list:
        return self.code._definitions.get(variable.name, [])

    def kinds(self, variable: ir.Var) -> list[types.Type | None]:
        """Errors: TypeError: a field is asked for of which `fields_used` has not seen that it is used."""
        kinds = [self.kind(each, 0) for each in self.definitions(variable)]
        if any(isinstance(kind, UnusedType) for kind in kinds):
            name = self.code.func_id.func_qualname
            raise TypeError(f"{name}: fields_used does not see that {variable.name} is asked for")
        return kinds

    def kind(self, value, depth: int) -> types.Type | None:
        """The type of what defines a variable, as far as arguments tell."""

        def of(variable: ir.Var) -> types.Type | None:
            definitions = self.definitions(variable) if depth < DEEPEST else []
            kinds = {self.kind(each, depth + 1) for each in definitions}
            return kinds.pop() if len(kinds) == 1 else None

        if isinstance(value, ir.Arg):
            kind = self.arguments[value.index]
            return (types.none if kind.value is None else None) if isinstance(kind, types.Omitted) else kind
        if isinstance(value, ir.Const | ir.Global | ir.FreeVar):
            return types.none if value.value is None else SOMETHING
        if isinstance(value, ir.Var):
            return of(value)
        op = value.op if isinstance(value, ir.Expr) else None
        if op == "build_tuple":
            return types.BaseTuple.from_types([of(item) or types.unknown for item in value.items])
        kind = of(value.value) if op in ("getattr", "exhaust_iter", "static_getitem", "getitem") else None
        if op == "exhaust_iter":
            return kind
        if op == "getattr":
            known = isinstance(kind, types.BaseNamedTuple) and value.attr in kind.fields
            return kind[kind.fields.index(value.attr)] if known else None
        if isinstance(kind, types.BaseTuple):
            index = value.index
            if isinstance(index, ir.Var):
                found = self.definitions(index)
                index = found[0].value if len(found) == 1 and isinstance(found[0], ir.Const) else None
            if isinstance(index, int) and index < len(kind) and kind[index] is not types.unknown:
                return kind[index]
        return None
