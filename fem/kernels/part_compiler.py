"""How parts are typed and compiled: for the fields that they use, once for all kernels, and without machine code.

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
from functools import cache, cached_property
from pathlib import Path
from types import ModuleType

from llvmlite.binding import parse_bitcode
from numba import njit, types
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
    used = _Reader(function).used
    return tuple(used[name] for name in inspect.signature(function).parameters)


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
            for target, value in (pair for each in ast.walk(node) for pair in _pairs(each)):
                if isinstance(target, ast.Name) and target.id != _root(value) and (new := self._paths(value)):
                    known = self.paths.setdefault(target.id, [])
                    known.extend(path for path in new if path not in known)
        for statement in node.body:
            self.visit(statement)

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
        name, called = _root(node.func), None
        if name is not None and name not in self.paths:
            called = self.globals.get(name)
            if isinstance(called, ModuleType) and isinstance(node.func, ast.Attribute):
                called = getattr(called, node.func.attr, None)
            elif name == "isinstance":
                self._use(node.args[0], {})
                return
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


# branches that types decide


DEEPEST = 16  # of names for names


class UnusedType(types.Type):
    """Numba type of a field that a part does not use: see `fields_used`."""


UNUSED = UnusedType("unused")
SOMETHING = types.pyobject  # the type of what is not None, where no more is known


@private.register_pass(mutates_CFG=True, analysis_only=False)
class KnownTypes(private.FunctionPass):
    """Questions that types answer become constants, branches are pruned."""

    _name = "known_types"

    def __init__(self):
        super().__init__()

    def run_pass(self, state) -> bool:
        code, changed = state.func_ir, False
        while _decide(code, state.args):  # a pruned branch may leave a name with one value
            private.dead_branch_prune(code, state.args)
            code._definitions, code._consts = (
                private.build_definitions(code.blocks),
                private.consts.ConstantInference(code),
            )
            changed = True
        return changed


class KernelCompiler(private.CompilerBase):
    """Numba's own compiler with this pass."""

    def define_pipelines(self):
        manager = private.DefaultPassBuilder.define_nopython_pipeline(self.state)
        manager.add_pass_after(KnownTypes, private.DeadBranchPrune)
        manager.finalize()
        return [manager]


def _decide(code: ir.FunctionIR, arguments: tuple) -> bool:
    """Put constants in place of questions that types answer; whether there are any.

    Errors: TypeError: a field is asked for of which `fields_used` has not seen that it is used.
    """
    decided = False
    for block in code.blocks.values():
        for statement in block.find_insts(ir.Assign):
            value = statement.value
            answer = _answer(code, arguments, value) if isinstance(value, ir.Expr) else None
            if answer is not None:
                statement.value = ir.Const(answer, value.loc)
                definitions = code._definitions[statement.target.name]
                definitions[definitions.index(value)] = statement.value
                decided = True
    return decided


def _answer(code: ir.FunctionIR, arguments: tuple, value: ir.Expr) -> bool | None:
    """What types tell of `x is None`, `x is not None` or `isinstance(x, Kind)`; None: nothing, or it is another."""
    if value.op == "binop" and value.fn in (operator.is_, operator.is_not):
        one, other = (_is_none(code, arguments, side) for side in (value.lhs, value.rhs))
        if None in (one, other) or not (one or other):  # unknown, or neither is None
            return None
        return (one == other) == (value.fn is operator.is_)
    if value.op != "call" or len(value.args) != 2:
        return None
    called, kind = ([d.value for d in code._definitions.get(v.name, []) if isinstance(d, ir.Global)]
                    for v in (value.func, value.args[1]))  # fmt: skip
    given = _kinds(code, arguments, value.args[0])
    if called != [isinstance] or len(kind) != 1 or len(given) != 1 or given[0] is None:
        return None
    return getattr(given[0], "instance_class", None) is kind[0]


def _is_none(code: ir.FunctionIR, arguments: tuple, variable: ir.Var) -> bool | None:
    """Whether a variable is None, in all that may define it; None: nobody knows."""
    kinds = _kinds(code, arguments, variable)
    answers = {None if k is None or isinstance(k, types.Optional) else isinstance(k, types.NoneType) for k in kinds}
    return answers.pop() if len(answers) == 1 else None


def _kinds(code: ir.FunctionIR, arguments: tuple, variable: ir.Var) -> list[types.Type | None]:
    kinds = [_kind(code, arguments, each, 0) for each in code._definitions.get(variable.name, [])]
    if any(isinstance(kind, UnusedType) for kind in kinds):
        raise TypeError(f"{code.func_id.func_qualname}: fields_used does not see that {variable.name} is asked for")
    return kinds


def _kind(code: ir.FunctionIR, arguments: tuple, value, depth: int) -> types.Type | None:
    """The type of what defines a variable, as far as arguments tell."""

    def of(variable: ir.Var) -> types.Type | None:
        definitions = code._definitions.get(variable.name, []) if depth < DEEPEST else []
        kinds = {_kind(code, arguments, each, depth + 1) for each in definitions}
        return kinds.pop() if len(kinds) == 1 else None

    if isinstance(value, ir.Arg):
        kind = arguments[value.index]
        return (types.none if kind.value is None else None) if isinstance(kind, types.Omitted) else kind
    if isinstance(value, ir.Const | ir.Global | ir.FreeVar):
        return types.none if value.value is None else SOMETHING
    if isinstance(value, ir.Var):
        return of(value)
    if not isinstance(value, ir.Expr):
        return None
    if value.op == "build_tuple":
        return types.BaseTuple.from_types([of(item) or types.unknown for item in value.items])
    if value.op == "getattr":
        kind = of(value.value)
        if isinstance(kind, types.BaseNamedTuple) and value.attr in kind.fields:
            return kind[kind.fields.index(value.attr)]
    if value.op == "exhaust_iter":
        return of(value.value)
    if value.op in ("static_getitem", "getitem"):
        kind, index = of(value.value), value.index
        if isinstance(index, ir.Var):
            found = code._definitions.get(index.name, [])
            index = found[0].value if len(found) == 1 and isinstance(found[0], ir.Const) else None
        if isinstance(kind, types.BaseTuple) and isinstance(index, int) and index < len(kind):
            return None if kind[index] is types.unknown else kind[index]
    return None


# code of parts


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


class PartLibrary(private.JITCodeLibrary):
    """LLVM's code of a part, for kernels to inline."""

    def _optimize_final_module(self):
        """Kernels do it."""

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        self._finalized = True


@private.register_pass(mutates_CFG=True, analysis_only=False)
class _PartLowering(private.NativeLowering):
    _name = "part_lowering"

    def run_pass(self, state):
        context, state.flags.no_compile = state.targetctx, True
        state.library = PartLibrary(context.codegen(), state.func_id.func_qualname)
        super().run_pass(state)
        lowered = state.cr
        state.library.finalize()
        state.cr = lowered._replace(cfunc=entry_point(lowered.fndesc, lowered.env, state.library))
        context.insert_user_function(state.cr.cfunc, lowered.fndesc, [state.library])
        return True


def entry_point(description, environment, library):
    """The object that stands for a compiled function in numba; not to be called."""
    return private._dynfunc.make_function(
        description.lookup_module(), description.qualname, "", 0, environment, (library,)
    )


def reduced(compiled) -> tuple:
    """What is kept of a compiled part."""
    library, description = compiled.library, compiled.fndesc
    description.typemap = description.calltypes = None
    return library.name, library._final_module.as_bitcode(), description, compiled.environment, compiled.signature


def rebuilt(context, name, code, description, environment, signature):
    """The compiled part of what `reduced` has kept."""
    library = PartLibrary(context.codegen(), name)
    library._final_module = parse_bitcode(code)
    library._finalize_final_module()
    return private.compile_result(
        typing_context=context.typing_context, target_context=context, signature=signature, objectmode=False,
        entry_point=entry_point(description, environment, library), fndesc=description, library=library,
        environment=environment, reload_init=(),
    )  # fmt: skip


class PartCompiler(KernelCompiler):
    """The kernels' compiler without machine code at its end."""

    def define_pipelines(self):
        (manager,) = super().define_pipelines()
        manager.passes = [
            (_PartLowering if each is private.NativeLowering else each, name) for each, name in manager.passes
        ]
        manager.finalize()
        return [manager]


class Code:
    """A function as the code of a part."""

    def __init__(self, function: Callable, options: dict, keep: Callable):
        self._function, self._options, self._keep = function, options, keep

    @cached_property
    def _dispatcher(self):
        wrappers = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        return self._keep(njit(pipeline_class=PartCompiler, **{**self._options, **wrappers})(self._function))

    def compiled(self, arguments, keywords):
        """Signature and entry point for arguments of some types."""
        python, arguments = self._dispatcher._compiler.fold_argument_types(arguments, keywords)
        kinds = tuple(map(narrowed, arguments, fields_used(self._function)))
        self._dispatcher.compile(kinds)
        found = self._dispatcher.overloads[kinds]
        return found.signature.replace(pysig=python), found.entry_point


def register(function: Callable, choose: Callable, code: Callable, of=types.Type) -> None:
    """Let kernels call a function: `choose` gives the `Code` for types of arguments, all of them of `code`.

    `of` : a kind of types that one argument has; of others it is whatever numba makes of the function
    """
    callees[function] = code

    class _Template(private.AbstractTemplate):
        key = function

        def generic(self, arguments, keywords):
            if arguments and not any(isinstance(each, of) for each in arguments):
                return None
            signature, self._entry = choose(*arguments).compiled(arguments, keywords)
            return signature

        def get_impl_key(self, signature):
            return self._entry

    private.infer_global(function, types.Function(_Template))
