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

import operator

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, lower_builtin, models, overload, register_model

from fem.kernels.numba_private import AbstractTemplate, cgutils, config, infer_global

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
for _name, _sign in {"lt": "<", "le": "<=", "gt": ">", "ge": ">=", "ne": "!=", "eq": "=="}.items():
    _define(getattr(operator, _name), _compare(_sign), MASK)
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


def _of_floats(name):
    """One of LLVM's functions of a float, of lanes too."""

    @intrinsic
    def function(typingctx, lanes):
        def codegen(context, builder, signature, arguments):
            return _call(builder, name, arguments)

        return like(LANES, lanes)(like(LANES, lanes)), codegen

    return function


square_root, absolute = _of_floats("llvm.sqrt"), _of_floats("llvm.fabs")


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


def _whole(kind, value):
    return ir.Constant(kind, [value] * WIDTH if isinstance(kind, ir.VectorType) else value)


@intrinsic
def exponent_and_mantissa(typingctx, lanes):
    """Of positive normal numbers: the power of two, as a float, and what is left, in [1, 2)."""
    kind = like(LANES, lanes)

    def codegen(context, builder, signature, arguments):
        floats, integers = (context.get_value_type(like(k, lanes)) for k in (LANES, WHOLE))

        bits = builder.bitcast(arguments[0], integers)
        power = builder.sub(builder.lshr(bits, _whole(integers, 52)), _whole(integers, 1023))
        rest = builder.or_(builder.and_(bits, _whole(integers, (1 << 52) - 1)), _whole(integers, 1023 << 52))
        values = [builder.sitofp(power, floats), builder.bitcast(rest, floats)]
        return context.make_tuple(builder, types.UniTuple(kind, 2), values)

    return types.UniTuple(kind, 2)(kind), codegen


@intrinsic
def power_of_two(typingctx, wholes):
    """2 to the power of whole numbers from −1022 to 1023."""
    kind = like(LANES, wholes)

    def codegen(context, builder, signature, arguments):
        integers = context.get_value_type(like(WHOLE, wholes))
        bits = builder.shl(builder.add(arguments[0], _whole(integers, 1023)), _whole(integers, 52))
        return builder.bitcast(bits, context.get_value_type(kind))

    return kind(like(WHOLE, wholes)), codegen


# ---- in and out of memory


def _of(array_type):
    return LANES if array_type.dtype == types.float64 else WHOLE


class _Memory:
    """An array's numbers."""

    def __init__(self, context, builder, array_type, array):
        self._context, self._builder = context, builder
        self._array = context.make_array(array_type)(context, builder, array)

    def at(self, index, count=1, beyond=None):
        """Where a number is, `beyond` another, with as many as `count` from there on."""
        builder, data = self._builder, self._array.data
        self.check(index if beyond is None else builder.add(index, beyond), count)
        return builder.gep(data if beyond is None else builder.gep(data, [beyond]), [index])

    def check(self, index, count=1):
        """End the kernel with an IndexError unless `count` numbers from an index on are the array's; if asked for."""
        if config.BOUNDSCHECK:
            for each in (index, self._builder.add(index, ir.Constant(WHOLE.vector.element, count - 1))):
                cgutils.do_boundscheck(self._context, self._builder, each, self._array.nitems)


@intrinsic
def load(typingctx, array, index):
    """Lanes at index ... index + 7."""
    lanes = _of(array)

    def codegen(context, builder, signature, arguments):
        pointer = _Memory(context, builder, array, arguments[0]).at(arguments[1], WIDTH)
        return builder.load(builder.bitcast(pointer, lanes.vector.as_pointer()), align=8)

    return lanes(array, types.intp), codegen


@intrinsic
def store(typingctx, array, index, lanes):
    """Write lanes to index ... index + 7, a scalar to index."""

    def codegen(context, builder, signature, arguments):
        memory, count = _Memory(context, builder, array, arguments[0]), WIDTH if isinstance(lanes, LanesType) else 1
        pointer = memory.at(arguments[1], count)
        builder.store(arguments[2], builder.bitcast(pointer, arguments[2].type.as_pointer()), align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, like(_of(array), lanes)), codegen


@intrinsic
def gather(typingctx, array, at):
    """Lanes from eight indices; lane by lane, which costs no more than the processor's own instruction."""
    lanes = _of(array)

    def codegen(context, builder, signature, arguments):
        memory = _Memory(context, builder, array, arguments[0])
        if not isinstance(at, LanesType):
            return builder.load(memory.at(arguments[1]))
        found = ir.Constant(lanes.vector, ir.Undefined)
        for k in range(WIDTH):
            index = builder.extract_element(arguments[1], lane(k))
            found = builder.insert_element(found, builder.load(memory.at(index)), lane(k))
        return found

    return like(lanes, at)(array, like(WHOLE, at)), codegen


@intrinsic
def gather_pair(typingctx, array, at, apart):
    """Lanes from eight indices, and from those `apart` further."""
    lanes = _of(array)
    kind = like(lanes, at)

    def codegen(context, builder, signature, arguments):
        memory, places = _Memory(context, builder, array, arguments[0]), (None, arguments[2])
        if not isinstance(at, LanesType):
            found = [builder.load(memory.at(arguments[1], beyond=beyond)) for beyond in places]
        else:
            found = [ir.Constant(lanes.vector, ir.Undefined)] * 2
            for k in range(WIDTH):
                index = builder.extract_element(arguments[1], lane(k))
                for i, beyond in enumerate(places):
                    value = builder.load(memory.at(index, beyond=beyond))
                    found[i] = builder.insert_element(found[i], value, lane(k))
        return context.make_tuple(builder, types.UniTuple(kind, 2), found)

    return types.UniTuple(kind, 2)(array, like(WHOLE, at), types.intp), codegen


@intrinsic
def scatter_add(typingctx, array, at, lanes):
    """Add lanes at eight indices one after the other, so that the same may come twice; at a number side by side."""

    def codegen(context, builder, signature, arguments):
        memory = _Memory(context, builder, array, arguments[0])
        if not isinstance(at, LanesType):
            pointer = builder.bitcast(memory.at(arguments[1], WIDTH), LANES.vector.as_pointer())
            builder.store(builder.fadd(builder.load(pointer, align=8), arguments[2]), pointer, align=8)
            return context.get_dummy_value()
        for k in range(WIDTH):
            pointer = memory.at(builder.extract_element(arguments[1], lane(k)))
            builder.store(builder.fadd(builder.load(pointer), builder.extract_element(arguments[2], lane(k))), pointer)
        return context.get_dummy_value()

    return types.void(array, like(WHOLE, at), LANES), codegen


def _elements(context, builder, kinds, arguments, offset=None, count=1, apart=None):
    """Eight elements of an array, at indices read from `places`, from `where` on, plus `offset`; `arguments` are these.

    Gives pairs of pointers: to an element, with `count` numbers from there on, and to what lies `apart` from it.
    """
    memory, indices = (_Memory(context, builder, *each) for each in zip(kinds[:2], arguments[:2], strict=True))
    first = indices.at(arguments[2], WIDTH)
    for k in range(WIDTH):
        index = builder.load(builder.gep(first, [lane(k)]))
        index = index if offset is None else builder.add(index, offset)
        pointer = memory.at(index, count)
        if apart is not None:
            memory.check(builder.add(index, apart))
        yield pointer, pointer if apart is None else builder.gep(pointer, [apart])


@intrinsic
def gather_places(typingctx, array, places, where, apart):
    """Lanes from the eight indices that stand in `places` from `where` on, and from those `apart` further.

    Indices from memory: to take them out of a register costs more.
    """

    def codegen(context, builder, signature, arguments):
        found = [ir.Constant(LANES.vector, ir.Undefined)] * 2
        for k, both in enumerate(_elements(context, builder, signature.args, arguments, apart=arguments[3])):
            for i, pointer in enumerate(both):
                found[i] = builder.insert_element(found[i], builder.load(pointer), lane(k))
        return context.make_tuple(builder, types.UniTuple(LANES, 2), found)

    return types.UniTuple(LANES, 2)(array, places, types.intp, types.intp), codegen


@intrinsic
def add_at_places(typingctx, array, places, where, apart, first, second):
    """Add lanes to what `gather_places` reads, one after the other."""

    def codegen(context, builder, signature, arguments):
        for k, both in enumerate(_elements(context, builder, signature.args, arguments, apart=arguments[3])):
            for at, lanes in zip(both, arguments[4:], strict=True):
                builder.store(builder.fadd(builder.load(at), builder.extract_element(lanes, lane(k))), at)
        return context.get_dummy_value()

    return types.void(array, places, types.intp, types.intp, LANES, LANES), codegen


def _shuffled(builder, one, other, chosen):
    return builder.shuffle_vector(one, other, ir.Constant(ir.VectorType(ir.IntType(32), len(chosen)), list(chosen)))


def _transposed(builder, rows):
    """Eight lanes of eight registers: the k-th lanes of all of them, for every k."""
    even, odd = (0, 8, 2, 10, 4, 12, 6, 14), (1, 9, 3, 11, 5, 13, 7, 15)
    first, second = (0, 1, 8, 9, 4, 5, 12, 13), (2, 3, 10, 11, 6, 7, 14, 15)
    low, high = (0, 1, 2, 3, 8, 9, 10, 11), (4, 5, 6, 7, 12, 13, 14, 15)
    columns = [None] * WIDTH
    for parity, chosen in enumerate((even, odd)):
        pairs = [_shuffled(builder, rows[k], rows[k + 1], chosen) for k in range(0, WIDTH, 2)]
        for next_two, of_pairs in enumerate((first, second)):
            top, bottom = (_shuffled(builder, pairs[k], pairs[k + 1], of_pairs) for k in (0, 2))
            at = parity + 2 * next_two
            columns[at] = _shuffled(builder, top, bottom, low)
            columns[at + 4] = _shuffled(builder, top, bottom, high)
    return columns


@intrinsic
def gather_rows(typingctx, array, places, where, offset):
    """Six entries in a row from each of the eight indices in `places` from `where` on plus `offset`: six lanes.

    Eight are read. A register for each and their transpose cost a third of six times `gather_places`.
    """

    def codegen(context, builder, signature, arguments):
        rows = [
            builder.load(builder.bitcast(pointer, LANES.vector.as_pointer()), align=8)
            for pointer, _ in _elements(context, builder, signature.args, arguments, arguments[3], WIDTH)
        ]
        return context.make_tuple(builder, types.UniTuple(LANES, 6), _transposed(builder, rows)[:6])

    return types.UniTuple(LANES, 6)(array, places, types.intp, types.intp), codegen


@intrinsic
def gather_quads(typingctx, array, at):
    """Four entries in a row from each of eight indices, or from one: four lanes, or scalars."""
    kind = like(LANES, at)

    def codegen(context, builder, signature, arguments):
        memory = _Memory(context, builder, array, arguments[0])
        if not isinstance(at, LanesType):
            first = memory.at(arguments[1], 4)
            found = [builder.load(builder.gep(first, [lane(k)])) for k in range(4)]
            return context.make_tuple(builder, types.UniTuple(kind, 4), found)
        four, rows = ir.VectorType(LANES.vector.element, 4), []
        for k in range(WIDTH):
            pointer = memory.at(builder.extract_element(arguments[1], lane(k)), 4)
            rows.append(builder.load(builder.bitcast(pointer, four.as_pointer()), align=8))
        # rows k and k + 4 side by side, then each half transposed
        rows = [_shuffled(builder, rows[k], rows[k + 4], range(WIDTH)) for k in range(4)]
        found = []
        for even_odd in ((0, 8, 2, 10, 4, 12, 6, 14), (1, 9, 3, 11, 5, 13, 7, 15)):
            pairs = [_shuffled(builder, rows[k], rows[k + 1], even_odd) for k in (0, 2)]
            found += [_shuffled(builder, *pairs, which)
                      for which in ((0, 1, 8, 9, 4, 5, 12, 13), (2, 3, 10, 11, 6, 7, 14, 15))]  # fmt: skip
        found = [found[k] for k in (0, 2, 1, 3)]
        return context.make_tuple(builder, types.UniTuple(kind, 4), found)

    return types.UniTuple(kind, 4)(array, like(WHOLE, at)), codegen


@intrinsic
def add_to_rows(typingctx, array, places, where, offset, six):
    """Add six lanes to what `gather_rows` reads, one row after the other: first the even lanes', then the odd ones'.

    Neighbouring rows may overlap, and a row that is read right after a part of it was written waits.
    """

    def codegen(context, builder, signature, arguments):
        lanes = [builder.extract_value(arguments[4], k) for k in range(6)]
        rows = _transposed(builder, lanes + [ir.Constant(LANES.vector, [0.0] * WIDTH)] * 2)
        pointers = [p for p, _ in _elements(context, builder, signature.args, arguments, arguments[3], 6)]
        for k in (*range(0, WIDTH, 2), *range(1, WIDTH, 2)):
            for first, size in ((0, 4), (4, 2)):
                part = _shuffled(builder, rows[k], rows[k], range(first, first + size))
                at = builder.bitcast(builder.gep(pointers[k], [lane(first)]), part.type.as_pointer())
                builder.store(builder.fadd(builder.load(at, align=8), part), at, align=8)
        return context.get_dummy_value()

    return types.void(array, places, types.intp, types.intp, types.UniTuple(LANES, 6)), codegen


if config.DISABLE_JIT:
    from fem.kernels.plain_lanes import *  # noqa: F403
