"""A pass of numba's compiler: branches on whether something is None, where types tell, are left out.

Numba prunes `if argument is None` itself. Here what is asked may be a field of an argument that is a named tuple, at
any depth, an entry of a tuple, or a name that is given to one of these, in branches too if all of them agree. So one
function serves scenes with a part and without it. What numba then cannot type (results of calls, `== None`, `if x.a:`)
ends in a TypingError, never in the wrong branch.
"""

import operator

from numba.core import consts, ir, types
from numba.core.analysis import dead_branch_prune
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.ir_utils import build_definitions
from numba.core.untyped_passes import DeadBranchPrune

DEEPEST = 16  # of names for names


class UnusedType(types.Type):
    """Numba type of a field that a part does not use: see `fields_used`."""


UNUSED = UnusedType("unused")
SOMETHING = types.pyobject  # the type of what is not None, where no more is known


@register_pass(mutates_CFG=True, analysis_only=False)
class KnownNone(FunctionPass):
    """Comparisons with None become constants, branches are pruned."""

    _name = "known_none"

    def __init__(self):
        super().__init__()

    def run_pass(self, state) -> bool:
        code, changed = state.func_ir, False
        while _decide(code, state.args):  # a pruned branch may leave a name with one value
            dead_branch_prune(code, state.args)
            code._definitions, code._consts = build_definitions(code.blocks), consts.ConstantInference(code)
            changed = True
        return changed


class KernelCompiler(CompilerBase):
    """Numba's own compiler with this pass."""

    def define_pipelines(self):
        manager = DefaultPassBuilder.define_nopython_pipeline(self.state)
        manager.add_pass_after(KnownNone, DeadBranchPrune)
        manager.finalize()
        return [manager]


def _decide(code: ir.FunctionIR, arguments: tuple) -> bool:
    """Put constants in place of comparisons; whether there are any.

    Errors
    ------
    TypeError: a field is compared with None of which `fields_used` has not seen that it is used.
    """
    decided = False
    for block in code.blocks.values():
        for statement in block.find_insts(ir.Assign):
            value = statement.value
            if not (isinstance(value, ir.Expr) and value.op == "binop" and value.fn in (operator.is_, operator.is_not)):
                continue
            one, other = (_is_none(code, arguments, side) for side in (value.lhs, value.rhs))
            if None in (one, other) or not (one or other):  # unknown, or neither is None
                continue
            statement.value = ir.Const((one == other) == (value.fn is operator.is_), value.loc)
            definitions = code._definitions[statement.target.name]
            definitions[definitions.index(value)] = statement.value
            decided = True
    return decided


def _is_none(code: ir.FunctionIR, arguments: tuple, variable: ir.Var) -> bool | None:
    """Whether a variable is None, in all that may define it; None: nobody knows."""
    kinds = [_kind(code, arguments, each, 0) for each in code._definitions.get(variable.name, [])]
    if any(isinstance(kind, UnusedType) for kind in kinds):
        raise TypeError(f"{code.func_id.func_qualname}: fields_used does not see that {variable.name} is compared")
    answers = {
        None if kind is None or isinstance(kind, types.Optional) else isinstance(kind, types.NoneType) for kind in kinds
    }
    return answers.pop() if len(answers) == 1 else None


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
