"""Eight lanes as one value inside numba kernels: floats, whole numbers and truth values, with Python's operators.

LLVM's loop vectoriser does not trust a gather over many rows (it must prove that no row overlaps the output) and falls
back to scalar code, 5 times slower. A value of eight lanes says what is meant. LLVM lowers it to whatever the processor
has: one AVX-512 register, two AVX, four SSE2 or NEON. A scalar beside lanes stands for all of them; products and sums
may be fused. All functions but those of neighbours, sums and `count_from` also take scalars for lanes, so that a kernel
can be called for one value. `lane_memory` brings lanes in and out, `lane_functions` has longer functions of them.
"""

import operator

from llvmlite import ir
from numba import types
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.extending import intrinsic, lower_builtin, models, overload, register_model

WIDTH = 8
_DOUBLE, _LONG, _BIT = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
_FUSED = ("contract",)


class LanesType(types.Type):
    """Numba type of eight lanes of one LLVM element type."""

    def __init__(self, name, element):
        super().__init__(name=name)
        self.vector = ir.VectorType(element, WIDTH)


LANES = LanesType("Lanes8", _DOUBLE)
WHOLE = LanesType("WholeLanes8", _LONG)
MASK = LanesType("MaskLanes8", _BIT)
_SCALARS = {LANES: types.float64, WHOLE: types.intp, MASK: types.boolean}


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, fe_type.vector)


def _splat(builder, scalar, vector):
    """A scalar in every lane."""
    empty = ir.Constant(vector, ir.Undefined)
    first = builder.insert_element(empty, scalar, ir.Constant(ir.IntType(32), 0))
    lanes = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(first, empty, lanes)


def like(kind, value_type):
    """Lanes of a kind, or its scalar, as the value is lanes or scalar."""
    return kind if isinstance(value_type, LanesType) else _SCALARS[kind]


def lane(number):
    """A lane's number as instructions take it."""
    return ir.Constant(ir.IntType(32), number)


def _as(builder, value, value_type, lanes):
    """The value, a scalar spread over all lanes."""
    return value if isinstance(value_type, LanesType) else _splat(builder, value, lanes.vector)


def _call(builder, name, arguments):
    """An intrinsic of floats that returns what it is given."""
    kind = arguments[0].type
    suffix = "v8f64" if isinstance(kind, ir.VectorType) else "f64"
    signature = ir.FunctionType(kind, [kind] * len(arguments))
    return builder.call(builder.module.declare_intrinsic(f"{name}.{suffix}", (), signature), arguments)


# ---- making and taking apart


@intrinsic
def splat(typingctx, scalar):
    """All lanes equal to a scalar."""
    lanes = WHOLE if isinstance(scalar, types.Integer) else LANES

    def codegen(context, builder, signature, arguments):
        return _splat(builder, arguments[0], lanes.vector)

    return lanes(types.intp if lanes is WHOLE else types.float64), codegen


def _shifted(first):
    """An intrinsic: eight lanes of two registers in a row, from lane `first` on."""

    def codegen(context, builder, signature, arguments):
        lanes = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [first + k for k in range(WIDTH)])
        return builder.shuffle_vector(*arguments, lanes)

    return LANES(LANES, LANES), codegen


@intrinsic
def from_left(typingctx, before, lanes):
    """Each lane's left neighbour; the first one's is the last of `before`."""
    return _shifted(WIDTH - 1)


@intrinsic
def from_right(typingctx, lanes, after):
    """Each lane's right neighbour; the last one's is the first of `after`."""
    return _shifted(1)


@intrinsic
def count_from(typingctx, first):
    """first, first + 1, ... first + 7."""

    def codegen(context, builder, signature, arguments):
        steps = ir.Constant(WHOLE.vector, list(range(WIDTH)))
        return builder.add(_splat(builder, arguments[0], WHOLE.vector), steps)

    return WHOLE(types.intp), codegen


@intrinsic
def to_int(typingctx, lanes):
    """Whole part of lanes that are not negative."""

    def codegen(context, builder, signature, arguments):
        return builder.fptosi(arguments[0], context.get_value_type(signature.return_type))

    return like(WHOLE, lanes)(like(LANES, lanes)), codegen


@intrinsic
def to_float(typingctx, lanes):
    """Whole numbers as floats."""

    def codegen(context, builder, signature, arguments):
        return builder.sitofp(arguments[0], context.get_value_type(signature.return_type))

    return like(LANES, lanes)(like(WHOLE, lanes)), codegen


@intrinsic
def total(typingctx, lanes):
    """Sum of the lanes, from first to last."""

    def codegen(context, builder, signature, arguments):
        found = builder.extract_element(arguments[0], lane(0))
        for k in range(1, WIDTH):
            found = builder.fadd(found, builder.extract_element(arguments[0], lane(k)))
        return found

    return types.float64(LANES), codegen


@intrinsic
def any_lane(typingctx, mask):
    """Whether any lane is true."""

    def codegen(context, builder, signature, arguments):
        if not isinstance(mask, LanesType):
            return arguments[0]
        bits = builder.bitcast(arguments[0], ir.IntType(WIDTH))
        return builder.icmp_unsigned("!=", bits, ir.Constant(bits.type, 0))

    return types.boolean(like(MASK, mask)), codegen


@intrinsic
def select(typingctx, mask, yes, no):
    """`yes` where the mask is true, else `no`; either may be a scalar."""
    kind = WHOLE if all(t == WHOLE or isinstance(t, types.Integer) for t in (yes, no)) else LANES

    def codegen(context, builder, signature, arguments):
        choices = arguments[1:]
        if isinstance(mask, LanesType):
            choices = [_as(builder, a, t, kind) for a, t in zip(choices, signature.args[1:], strict=True)]
        return builder.select(arguments[0], *choices)

    return like(kind, mask)(like(MASK, mask), like(kind, yes), like(kind, no)), codegen


# ---- arithmetic


def _operands(left, right):
    """The lanes a pair of operands makes, or None."""
    found = {t for t in (left, right) if isinstance(t, LanesType)}
    scalars = [t for t in (left, right) if not isinstance(t, LanesType)]
    if len(found) != 1:
        return None
    (lanes,) = found
    fitting = {LANES: types.Float, WHOLE: types.Integer}.get(lanes, ())
    return lanes if all(isinstance(t, fitting) for t in scalars) else None


def _define(symbol, build, result=None, kinds=(LANES, WHOLE)):
    """Give an operator to lanes; `build(builder, lanes, left, right)`; `result`: None for the operands' own kind.

    Lowered to its one instruction: a function for each operator and kind takes longer to compile than all the rest.
    """

    @infer_global(symbol)
    class _Typing(AbstractTemplate):
        def generic(self, arguments, keywords):
            lanes = _operands(*arguments) if len(arguments) == 2 else None
            if lanes not in kinds:
                return None
            return (result or lanes)(*(like(lanes, argument) for argument in arguments))

    def lower(context, builder, signature, arguments):
        lanes = _operands(*signature.args)
        pair = [_as(builder, a, t, lanes) for a, t in zip(arguments, signature.args, strict=True)]
        return build(builder, lanes, *pair)

    for lanes in kinds:
        scalar = _SCALARS[lanes]
        for left, right in ((lanes, lanes), (lanes, scalar), (scalar, lanes)):
            lower_builtin(symbol, left, right)(lower)


def _either(of_floats, of_wholes):
    def build(builder, lanes, left, right):
        if lanes is LANES:
            return getattr(builder, of_floats)(left, right, flags=_FUSED)
        return getattr(builder, of_wholes)(left, right)

    return build


def _compare(sign):
    def build(builder, lanes, left, right):
        if lanes is LANES:
            compare = builder.fcmp_unordered if sign == "!=" else builder.fcmp_ordered
            return compare(sign, left, right)
        return builder.icmp_signed(sign, left, right)

    return build


for _symbol in (operator.add, operator.iadd):
    _define(_symbol, _either("fadd", "add"))
for _symbol in (operator.sub, operator.isub):
    _define(_symbol, _either("fsub", "sub"))
_define(operator.mul, _either("fmul", "mul"))
_define(operator.truediv, lambda builder, lanes, left, right: builder.fdiv(left, right), kinds=(LANES,))
for _symbol, _sign in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.ne, "!="),
    (operator.eq, "=="),
):
    _define(_symbol, _compare(_sign), MASK)
_define(operator.and_, lambda builder, lanes, left, right: builder.and_(left, right), kinds=(MASK,))
_define(operator.or_, lambda builder, lanes, left, right: builder.or_(left, right), kinds=(MASK,))


@intrinsic
def _negated(typingctx, lanes):
    def codegen(context, builder, signature, arguments):
        return builder.fneg(arguments[0])

    return LANES(LANES), codegen


@overload(operator.neg)
def _negate(lanes):
    return (lambda lanes: _negated(lanes)) if lanes == LANES else None


@intrinsic
def square_root(typingctx, lanes):
    """Square root."""

    def codegen(context, builder, signature, arguments):
        return _call(builder, "llvm.sqrt", arguments)

    return like(LANES, lanes)(like(LANES, lanes)), codegen


@intrinsic
def absolute(typingctx, lanes):
    """Absolute value."""

    def codegen(context, builder, signature, arguments):
        return _call(builder, "llvm.fabs", arguments)

    return like(LANES, lanes)(like(LANES, lanes)), codegen


@intrinsic
def with_sign(typingctx, lanes, sign):
    """Magnitude of the first, sign of the second."""

    def codegen(context, builder, signature, arguments):
        return _call(builder, "llvm.copysign", arguments)

    return like(LANES, lanes)(like(LANES, lanes), like(LANES, sign)), codegen


@intrinsic
def fma(typingctx, scalar, lanes, addend):
    """scalar·lanes + addend."""

    def codegen(context, builder, signature, arguments):
        factor = _splat(builder, arguments[0], LANES.vector)
        # fmuladd, not fma: a processor without the fused instruction multiplies and adds instead of calling a library
        return _call(builder, "llvm.fmuladd", [factor, *arguments[1:]])

    return LANES(types.float64, LANES, LANES), codegen


@intrinsic
def exponent_and_mantissa(typingctx, lanes):
    """Of positive normal numbers: the power of two, as a float, and what is left, in [1, 2)."""
    kind = like(LANES, lanes)

    def codegen(context, builder, signature, arguments):
        floats, integers = (context.get_value_type(like(k, lanes)) for k in (LANES, WHOLE))

        def constant(value):
            return ir.Constant(integers, [value] * WIDTH if isinstance(lanes, LanesType) else value)

        bits = builder.bitcast(arguments[0], integers)
        power = builder.sub(builder.lshr(bits, constant(52)), constant(1023))
        rest = builder.or_(builder.and_(bits, constant((1 << 52) - 1)), constant(1023 << 52))
        values = [builder.sitofp(power, floats), builder.bitcast(rest, floats)]
        return context.make_tuple(builder, types.UniTuple(kind, 2), values)

    return types.UniTuple(kind, 2)(kind), codegen


@intrinsic
def power_of_two(typingctx, wholes):
    """2 to the power of whole numbers from −1022 to 1023."""
    kind = like(LANES, wholes)

    def codegen(context, builder, signature, arguments):
        integers = context.get_value_type(like(WHOLE, wholes))

        def constant(value):
            return ir.Constant(integers, [value] * WIDTH if isinstance(wholes, LanesType) else value)

        bits = builder.shl(builder.add(arguments[0], constant(1023)), constant(52))
        return builder.bitcast(bits, context.get_value_type(kind))

    return kind(like(WHOLE, wholes)), codegen
