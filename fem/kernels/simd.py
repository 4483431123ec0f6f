"""Eight float64 lanes as one value inside numba kernels.

LLVM's loop vectoriser does not trust a gather over many rows (it must prove that no row overlaps the output) and falls
back to scalar code, 5 times slower. A value of eight lanes says what is meant. LLVM lowers it to whatever the processor
has: one AVX-512 register, two AVX, four SSE2 or NEON.
"""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, models, register_model

WIDTH = 8
_VECTOR = ir.VectorType(ir.DoubleType(), WIDTH)


class LanesType(types.Type):
    """Numba type of eight float64 lanes."""

    def __init__(self):
        super().__init__(name="Lanes8")


LANES = LanesType()


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, _VECTOR)


def _pointer(context, builder, array_type, array, index):
    data = context.make_array(array_type)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), _VECTOR.as_pointer())


def _splat(builder, scalar):
    empty = ir.Constant(_VECTOR, ir.Undefined)
    first = builder.insert_element(empty, scalar, ir.Constant(ir.IntType(32), 0))
    lanes = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(first, empty, lanes)


def _multiply_add(builder, left, right, addend):
    # fmuladd, not fma: a processor without the fused instruction multiplies and adds instead of calling a library
    signature = ir.FunctionType(_VECTOR, [_VECTOR] * 3)
    function = builder.module.declare_intrinsic("llvm.fmuladd.v8f64", (), signature)
    return builder.call(function, [left, right, addend])


@intrinsic
def load(typingctx, flat, index):
    """Lanes flat[index : index + 8] of a C-ordered one-dimensional float64 array; unchecked."""

    def codegen(context, builder, signature, arguments):
        return builder.load(_pointer(context, builder, signature.args[0], *arguments), align=8)

    return LANES(flat, types.intp), codegen


@intrinsic
def store(typingctx, flat, index, lanes):
    """flat[index : index + 8] = lanes; unchecked."""

    def codegen(context, builder, signature, arguments):
        array, at, value = arguments
        builder.store(value, _pointer(context, builder, signature.args[0], array, at), align=8)
        return context.get_dummy_value()

    return types.void(flat, types.intp, LANES), codegen


@intrinsic
def splat(typingctx, scalar):
    """All lanes equal to a scalar."""

    def codegen(context, builder, signature, arguments):
        return _splat(builder, arguments[0])

    return LANES(types.float64), codegen


@intrinsic
def fma(typingctx, scalar, lanes, addend):
    """scalar·lanes + addend."""

    def codegen(context, builder, signature, arguments):
        factor, value, rest = arguments
        return _multiply_add(builder, _splat(builder, factor), value, rest)

    return LANES(types.float64, LANES, LANES), codegen


@intrinsic
def fma_lanes(typingctx, left, right, addend):
    """left·right + addend, lane by lane."""

    def codegen(context, builder, signature, arguments):
        return _multiply_add(builder, *arguments)

    return LANES(LANES, LANES, LANES), codegen


@intrinsic
def add(typingctx, left, right):
    """left + right, lane by lane."""

    def codegen(context, builder, signature, arguments):
        return builder.fadd(*arguments)

    return LANES(LANES, LANES), codegen


@intrinsic
def subtract(typingctx, left, right):
    """left − right, lane by lane."""

    def codegen(context, builder, signature, arguments):
        return builder.fsub(*arguments)

    return LANES(LANES, LANES), codegen


@intrinsic
def multiply(typingctx, left, right):
    """left·right, lane by lane."""

    def codegen(context, builder, signature, arguments):
        return builder.fmul(*arguments)

    return LANES(LANES, LANES), codegen
