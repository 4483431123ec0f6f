"""Eight lanes as one value inside numba kernels: floats, whole numbers and truth values, with Python's operators.

LLVM's loop vectoriser does not trust a gather over many rows (it must prove that no row overlaps the output) and falls
back to scalar code, 5 times slower. A value of eight lanes says what is meant. LLVM lowers it to whatever the processor
has: one AVX-512 register, two AVX, four SSE2 or NEON. A scalar beside lanes stands for all of them; products and sums
may be fused. All functions but those of neighbours, sums and `count_from` also take scalars for lanes, so that a kernel
can be called for one value. `lane_functions` has longer functions of them.

Memory is addressed by a flat index into a C-ordered array of any shape: unchecked, but with numba's own
NUMBA_BOUNDSCHECK=1, which then holds for lanes as for single numbers. `store`, `gather`, `gather_pair` and
`gather_quads` also take scalars for lanes.
"""

import inspect
import operator
from collections.abc import Callable
from functools import wraps

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, lower_builtin, models, overload, register_model

from fem.kernels.numba_private import AbstractTemplate, cgutils, config, infer_global

WIDTH = 8
_DOUBLE, _LONG, _BIT, _PLACE = ir.DoubleType(), ir.IntType(64), ir.IntType(1), ir.IntType(32)
_FUSED = ("contract",)


class LanesType(types.Type):
    """Numba type of eight lanes of one LLVM element type."""

    def __init__(self, name, element):
        super().__init__(name=name)
        self.vector = ir.VectorType(element, WIDTH)


LANES, WHOLE, MASK = LanesType("Lanes8", _DOUBLE), LanesType("WholeLanes8", _LONG), LanesType("MaskLanes8", _BIT)
_SCALARS = {LANES: types.float64, WHOLE: types.intp, MASK: types.boolean}
_SIX = types.UniTuple(LANES, 6)


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, fe_type.vector)


def like(kind, value_type):
    """Lanes of a kind, or its scalar, as the value is lanes or scalar."""
    return kind if isinstance(value_type, LanesType) else _SCALARS[kind]


def lane(number):
    """A lane's number as instructions take it."""
    return ir.Constant(_PLACE, number)


def _nothing(lanes=LANES):
    return ir.Constant(lanes.vector, ir.Undefined)


def _shuffled(builder, one, other, chosen):
    return builder.shuffle_vector(one, other, ir.Constant(ir.VectorType(_PLACE, len(chosen)), list(chosen)))


def _splat(builder, scalar, lanes):
    first = builder.insert_element(_nothing(lanes), scalar, lane(0))
    return _shuffled(builder, first, _nothing(lanes), [0] * WIDTH)


def _as(builder, value, value_type, lanes):
    """The value, a scalar spread over all lanes."""
    return value if isinstance(value_type, LanesType) else _splat(builder, value, lanes)


def _call(builder, name, *arguments):
    """An intrinsic of floats that returns what it is given."""
    kind = arguments[0].type
    suffix = "v8f64" if isinstance(kind, ir.VectorType) else "f64"
    signature = ir.FunctionType(kind, [kind] * len(arguments))
    return builder.call(builder.module.declare_intrinsic(f"{name}.{suffix}", (), signature), arguments)


def _pair_or_more(context, builder, kind, found):
    return context.make_tuple(builder, types.UniTuple(kind, len(found)), found)


def _instruction(sign: Callable):
    """What kernels call by the function that builds it from a compiler's context, builder, signature, and from values.

    `sign` : its signature by the types of what it is called with
    """

    def defined(build):
        @wraps(build)
        def typed(typingctx, *kinds):
            return sign(*kinds), lambda context, builder, signature, values: build(context, builder, signature, *values)

        # numba leaves out the first
        typed.__signature__ = inspect.Signature(list(inspect.signature(build).parameters.values())[2:])
        return intrinsic(typed)

    return defined


# ---- making and taking apart


@_instruction(lambda kind: WHOLE(types.intp) if isinstance(kind, types.Integer) else LANES(types.float64))
def splat(context, builder, signature, scalar):
    """All lanes equal to a scalar."""
    return _splat(builder, scalar, signature.return_type)


@_instruction(lambda before, lanes: LANES(LANES, LANES))
def from_left(context, builder, signature, before, lanes):
    """Each lane's left neighbour; the first one's is the last of `before`."""
    return _shuffled(builder, before, lanes, range(WIDTH - 1, 2 * WIDTH - 1))


@_instruction(lambda lanes, after: LANES(LANES, LANES))
def from_right(context, builder, signature, lanes, after):
    """Each lane's right neighbour; the last one's is the first of `after`."""
    return _shuffled(builder, lanes, after, range(1, WIDTH + 1))


@_instruction(lambda first: WHOLE(types.intp))
def count_from(context, builder, signature, first):
    """first, first + 1, ... first + 7."""
    return builder.add(_splat(builder, first, WHOLE), ir.Constant(WHOLE.vector, list(range(WIDTH))))


@_instruction(lambda lanes: like(WHOLE, lanes)(like(LANES, lanes)))
def to_int(context, builder, signature, lanes):
    """Whole part of lanes that are not negative."""
    return builder.fptosi(lanes, context.get_value_type(signature.return_type))


@_instruction(lambda lanes: like(LANES, lanes)(like(WHOLE, lanes)))
def to_float(context, builder, signature, lanes):
    """Whole numbers as floats."""
    return builder.sitofp(lanes, context.get_value_type(signature.return_type))


@_instruction(lambda lanes: types.float64(LANES))
def total(context, builder, signature, lanes):
    """Sum of the lanes, from first to last."""
    found = builder.extract_element(lanes, lane(0))
    for k in range(1, WIDTH):
        found = builder.fadd(found, builder.extract_element(lanes, lane(k)))
    return found


@_instruction(lambda mask: types.boolean(like(MASK, mask)))
def any_lane(context, builder, signature, mask):
    """Whether any lane is true."""
    if signature.args[0] != MASK:
        return mask
    bits = builder.bitcast(mask, ir.IntType(WIDTH))
    return builder.icmp_unsigned("!=", bits, ir.Constant(bits.type, 0))


def _chosen(mask, yes, no):
    kind = WHOLE if all(t == WHOLE or isinstance(t, types.Integer) for t in (yes, no)) else LANES
    return like(kind, mask)(like(MASK, mask), like(kind, yes), like(kind, no))


@_instruction(_chosen)
def select(context, builder, signature, mask, yes, no):
    """`yes` where the mask is true, else `no`; either may be a scalar."""
    lanes, choices = signature.return_type, (yes, no)
    if isinstance(lanes, LanesType):
        choices = [_as(builder, value, t, lanes) for value, t in zip(choices, signature.args[1:], strict=True)]
    return builder.select(mask, *choices)


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
            return (result or lanes)(*(like(lanes, argument) for argument in arguments)) if lanes in kinds else None

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


for _symbols, _build in (
    ((operator.add, operator.iadd), _either("fadd", "add")), ((operator.sub, operator.isub), _either("fsub", "sub")),
    ((operator.mul,), _either("fmul", "mul")),
):  # fmt: skip
    for _symbol in _symbols:
        _define(_symbol, _build)
_define(operator.truediv, lambda builder, lanes, left, right: builder.fdiv(left, right), kinds=(LANES,))
for _name, _sign in {"lt": "<", "le": "<=", "gt": ">", "ge": ">=", "ne": "!=", "eq": "=="}.items():
    _define(getattr(operator, _name), _compare(_sign), MASK)
_define(operator.and_, lambda builder, lanes, left, right: builder.and_(left, right), kinds=(MASK,))
_define(operator.or_, lambda builder, lanes, left, right: builder.or_(left, right), kinds=(MASK,))


@_instruction(lambda lanes: LANES(LANES))
def _negated(context, builder, signature, lanes):
    return builder.fneg(lanes)


@overload(operator.neg)
def _negate(lanes):
    return (lambda lanes: _negated(lanes)) if lanes == LANES else None


def _of_floats(name):
    """One of LLVM's functions of a float, of lanes too."""

    @_instruction(lambda lanes: like(LANES, lanes)(like(LANES, lanes)))
    def function(context, builder, signature, lanes):
        return _call(builder, name, lanes)

    return function


square_root, absolute = _of_floats("llvm.sqrt"), _of_floats("llvm.fabs")


@_instruction(lambda lanes, sign: like(LANES, lanes)(like(LANES, lanes), like(LANES, sign)))
def with_sign(context, builder, signature, lanes, sign):
    """Magnitude of the first, sign of the second."""
    return _call(builder, "llvm.copysign", lanes, sign)


@_instruction(lambda scalar, lanes, addend: LANES(types.float64, LANES, LANES))
def fma(context, builder, signature, scalar, lanes, addend):
    """scalar·lanes + addend."""
    # fmuladd, not fma: a processor without the fused instruction multiplies and adds instead of calling a library
    return _call(builder, "llvm.fmuladd", _splat(builder, scalar, LANES), lanes, addend)


def _whole(kind, value):
    return ir.Constant(kind, [value] * WIDTH if isinstance(kind, ir.VectorType) else value)


@_instruction(lambda lanes: types.UniTuple(like(LANES, lanes), 2)(like(LANES, lanes)))
def exponent_and_mantissa(context, builder, signature, lanes):
    """Of positive normal numbers: the power of two, as a float, and what is left, in [1, 2)."""
    (kind,) = signature.args
    floats, integers = (context.get_value_type(like(k, kind)) for k in (LANES, WHOLE))
    bits = builder.bitcast(lanes, integers)
    power = builder.sub(builder.lshr(bits, _whole(integers, 52)), _whole(integers, 1023))
    rest = builder.or_(builder.and_(bits, _whole(integers, (1 << 52) - 1)), _whole(integers, 1023 << 52))
    return _pair_or_more(context, builder, kind, [builder.sitofp(power, floats), builder.bitcast(rest, floats)])


@_instruction(lambda wholes: like(LANES, wholes)(like(WHOLE, wholes)))
def power_of_two(context, builder, signature, wholes):
    """2 to the power of whole numbers from −1022 to 1023."""
    integers = context.get_value_type(signature.args[0])
    bits = builder.shl(builder.add(wholes, _whole(integers, 1023)), _whole(integers, 52))
    return builder.bitcast(bits, context.get_value_type(signature.return_type))


# ---- in and out of memory


def _of(array_type):
    return LANES if array_type.dtype == types.float64 else WHOLE


class _Memory:
    """The numbers of the array that is the first of an instruction's values."""

    def __init__(self, context, builder, signature, array, argument=0):
        kind = signature.args[argument]
        self._context, self._builder = context, builder
        self._array = context.make_array(kind)(context, builder, array)

    def at(self, index, count=1, beyond=None):
        """Where a number is, `beyond` another, with as many as `count` from there on."""
        builder, data = self._builder, self._array.data
        self.check(index if beyond is None else builder.add(index, beyond), count)
        return builder.gep(data if beyond is None else builder.gep(data, [beyond]), [index])

    def lanes_at(self, index, vector=LANES.vector, beyond=None):
        """Where lanes are that stand in a row from a number on."""
        return self._builder.bitcast(self.at(index, vector.count, beyond), vector.as_pointer())

    def check(self, index, count=1):
        """End the kernel with an IndexError unless `count` numbers from an index on are the array's; if asked for."""
        if config.BOUNDSCHECK:
            for each in (index, self._builder.add(index, ir.Constant(_LONG, count - 1))):
                cgutils.do_boundscheck(self._context, self._builder, each, self._array.nitems)


@_instruction(lambda array, index: _of(array)(array, types.intp))
def load(context, builder, signature, array, index):
    """Lanes at index ... index + 7."""
    memory = _Memory(context, builder, signature, array)
    return builder.load(memory.lanes_at(index, signature.return_type.vector), align=8)


@_instruction(lambda array, index, lanes: types.void(array, types.intp, like(_of(array), lanes)))
def store(context, builder, signature, array, index, lanes):
    """Write lanes to index ... index + 7, a scalar to index."""
    memory = _Memory(context, builder, signature, array)
    pointer = memory.at(index, WIDTH if isinstance(signature.args[2], LanesType) else 1)
    builder.store(lanes, builder.bitcast(pointer, lanes.type.as_pointer()), align=8)
    return context.get_dummy_value()


def _gathered(builder, memory, at, kind, lanes, beyonds):
    """Lanes from eight indices, or numbers from one; and from what lies `beyonds` further."""
    if not isinstance(kind, LanesType):
        return [builder.load(memory.at(at, beyond=beyond)) for beyond in beyonds]
    found = [_nothing(lanes) for _ in beyonds]
    for k in range(WIDTH):
        index = builder.extract_element(at, lane(k))
        for i, beyond in enumerate(beyonds):
            found[i] = builder.insert_element(found[i], builder.load(memory.at(index, beyond=beyond)), lane(k))
    return found


@_instruction(lambda array, at: like(_of(array), at)(array, like(WHOLE, at)))
def gather(context, builder, signature, array, at):
    """Lanes from eight indices; lane by lane, which costs no more than the processor's own instruction."""
    (kind, index), memory = signature.args, _Memory(context, builder, signature, array)
    return _gathered(builder, memory, at, index, _of(kind), (None,))[0]


@_instruction(lambda array, at, apart: types.UniTuple(like(_of(array), at), 2)(array, like(WHOLE, at), types.intp))
def gather_pair(context, builder, signature, array, at, apart):
    """Lanes from eight indices, and from those `apart` further."""
    (kind, index, _), memory = signature.args, _Memory(context, builder, signature, array)
    found = _gathered(builder, memory, at, index, _of(kind), (None, apart))
    return _pair_or_more(context, builder, like(_of(kind), index), found)


@_instruction(lambda array, at, lanes: types.void(array, like(WHOLE, at), LANES))
def scatter_add(context, builder, signature, array, at, lanes):
    """Add lanes at eight indices one after the other, so that the same may come twice; at a number side by side."""
    memory = _Memory(context, builder, signature, array)
    if signature.args[1] != WHOLE:
        pointer = memory.lanes_at(at)
        builder.store(builder.fadd(builder.load(pointer, align=8), lanes), pointer, align=8)
        return context.get_dummy_value()
    for k in range(WIDTH):
        pointer = memory.at(builder.extract_element(at, lane(k)))
        builder.store(builder.fadd(builder.load(pointer), builder.extract_element(lanes, lane(k))), pointer)
    return context.get_dummy_value()


def _elements(context, builder, signature, array, places, where, offset=None, count=1, apart=None):
    """Eight elements of an array, at indices read from `places`, from `where` on, plus `offset`.

    Gives pairs of pointers: to an element, with `count` numbers from there on, and to what lies `apart` from it.
    """
    memory = _Memory(context, builder, signature, array)
    first = _Memory(context, builder, signature, places, 1).at(where, WIDTH)
    for k in range(WIDTH):
        index = builder.load(builder.gep(first, [lane(k)]))
        index = index if offset is None else builder.add(index, offset)
        pointer = memory.at(index, count)
        if apart is not None:
            memory.check(builder.add(index, apart))
        yield pointer, pointer if apart is None else builder.gep(pointer, [apart])


@_instruction(lambda array, places, *_: types.UniTuple(_SIX, 2)(array, places, types.intp, types.intp))
def gather_nodes(context, builder, signature, array, places, where, apart):
    """Six times lanes from eight indices that stand in `places` from `where` on, each time `apart` further; and what
    lies `apart` from these: x and y.

    Indices from memory: to take them out of a register costs more.
    """
    found = []
    for _ in range(6):
        both = [_nothing(), _nothing()]
        for k, pointers in enumerate(_elements(context, builder, signature, array, places, where, apart=apart)):
            for i, pointer in enumerate(pointers):
                both[i] = builder.insert_element(both[i], builder.load(pointer), lane(k))
        found.append(both)
        where = builder.add(where, apart)
    sixes = [_pair_or_more(context, builder, LANES, six) for six in zip(*found, strict=True)]
    return _pair_or_more(context, builder, _SIX, sixes)


@_instruction(lambda array, places, *_: types.void(array, places, types.intp, types.intp, LANES, LANES))
def add_at_places(context, builder, signature, array, places, where, apart, first, second):
    """Add lanes to the first of what `gather_nodes` reads, one after the other."""
    for k, both in enumerate(_elements(context, builder, signature, array, places, where, apart=apart)):
        for at, lanes in zip(both, (first, second), strict=True):
            builder.store(builder.fadd(builder.load(at), builder.extract_element(lanes, lane(k))), at)
    return context.get_dummy_value()


_PAIRS, _LOW_HALVES = ((0, 8, 2, 10, 4, 12, 6, 14), (1, 9, 3, 11, 5, 13, 7, 15)), (0, 1, 2, 3, 8, 9, 10, 11)
_QUADS, _HIGH_HALVES = ((0, 1, 8, 9, 4, 5, 12, 13), (2, 3, 10, 11, 6, 7, 14, 15)), (4, 5, 6, 7, 12, 13, 14, 15)


def _transposed(builder, rows):
    """Eight lanes of eight registers: the k-th lanes of all of them, for every k."""
    columns = [None] * WIDTH
    for parity, chosen in enumerate(_PAIRS):
        pairs = [_shuffled(builder, rows[k], rows[k + 1], chosen) for k in range(0, WIDTH, 2)]
        for next_two, of_pairs in enumerate(_QUADS):
            top, bottom = (_shuffled(builder, pairs[k], pairs[k + 1], of_pairs) for k in (0, 2))
            at = parity + 2 * next_two
            columns[at] = _shuffled(builder, top, bottom, _LOW_HALVES)
            columns[at + 4] = _shuffled(builder, top, bottom, _HIGH_HALVES)
    return columns


@_instruction(lambda array, places, *_: _SIX(array, places, types.intp, types.intp))
def gather_rows(context, builder, signature, array, places, where, offset):
    """Six entries in a row from each of the eight indices in `places` from `where` on plus `offset`: six lanes.

    Eight are read. A register for each and their transpose cost a third of six gathers.
    """
    pointers = _elements(context, builder, signature, array, places, where, offset, WIDTH)
    rows = [builder.load(builder.bitcast(pointer, LANES.vector.as_pointer()), align=8) for pointer, _ in pointers]
    return _pair_or_more(context, builder, LANES, _transposed(builder, rows)[:6])


@_instruction(lambda array, at: types.UniTuple(like(LANES, at), 4)(array, like(WHOLE, at)))
def gather_quads(context, builder, signature, array, at):
    """Four entries in a row from each of eight indices, or from one: four lanes, or scalars."""
    memory = _Memory(context, builder, signature, array)
    if signature.args[1] != WHOLE:
        first = memory.at(at, 4)
        found = [builder.load(builder.gep(first, [lane(k)])) for k in range(4)]
        return _pair_or_more(context, builder, types.float64, found)
    four, rows = ir.VectorType(_DOUBLE, 4), []
    for k in range(WIDTH):
        rows.append(builder.load(memory.lanes_at(builder.extract_element(at, lane(k)), four), align=8))
    # rows k and k + 4 side by side, then each half transposed
    rows = [_shuffled(builder, rows[k], rows[k + 4], range(WIDTH)) for k in range(4)]
    found = []
    for even_odd in _PAIRS:
        pairs = [_shuffled(builder, rows[k], rows[k + 1], even_odd) for k in (0, 2)]
        found += [_shuffled(builder, *pairs, which) for which in _QUADS]
    return _pair_or_more(context, builder, LANES, [found[k] for k in (0, 2, 1, 3)])


@_instruction(lambda array, places, *_: types.void(array, places, types.intp, types.intp, _SIX))
def add_to_rows(context, builder, signature, array, places, where, offset, six):
    """Add six lanes to what `gather_rows` reads, one row after the other: first the even lanes', then the odd ones'.

    Neighbouring rows may overlap, and a row that is read right after a part of it was written waits.
    """
    lanes = [builder.extract_value(six, k) for k in range(6)]
    rows = _transposed(builder, lanes + [ir.Constant(LANES.vector, [0.0] * WIDTH)] * 2)
    pointers = [p for p, _ in _elements(context, builder, signature, array, places, where, offset, 6)]
    for k in (*range(0, WIDTH, 2), *range(1, WIDTH, 2)):
        for first, size in ((0, 4), (4, 2)):
            part = _shuffled(builder, rows[k], rows[k], range(first, first + size))
            at = builder.bitcast(builder.gep(pointers[k], [lane(first)]), part.type.as_pointer())
            builder.store(builder.fadd(builder.load(at, align=8), part), at, align=8)
    return context.get_dummy_value()


if config.DISABLE_JIT:
    from fem.kernels.plain_lanes import *  # noqa: F403
