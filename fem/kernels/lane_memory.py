"""Lanes in and out of memory: loads and stores of neighbours, gathers and scatters, rows that are transposed.

Memory is addressed by a flat index into a C-ordered array of any shape: unchecked, but with numba's own
NUMBA_BOUNDSCHECK=1, which then holds for lanes as for single numbers. `store`, `gather`, `gather_pair` and
`gather_quads` also take scalars for lanes.
"""

from llvmlite import ir
from numba import types
from numba.core import cgutils, config
from numba.extending import intrinsic

from fem.kernels.lanes import LANES, WHOLE, WIDTH, LanesType, lane, like


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
def sums_of_rows(typingctx, array, index):
    """Sums of eight rows of eight that stand one after the other from an index on, each from first to last: lanes."""

    def codegen(context, builder, signature, arguments):
        memory = _Memory(context, builder, array, arguments[0])
        pointer = memory.at(arguments[1], WIDTH * WIDTH)
        rows = [builder.gep(pointer, [lane(WIDTH * k)]) for k in range(WIDTH)]
        rows = [builder.load(builder.bitcast(row, LANES.vector.as_pointer()), align=8) for row in rows]
        found, *others = _transposed(builder, rows)
        for column in others:
            found = builder.fadd(found, column)
        return found

    return LANES(array, types.intp), codegen


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
