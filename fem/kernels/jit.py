"""How functions of the time loop are compiled: `@kernel`, `@part`, `@verb`, `every`; once per version of the code.

A `@kernel` is called from Python. A `@part` stands in the code of the kernels that call it and nowhere else: a function
that Python may call has code that takes apart every array of its arguments, which for those of the time loop takes
0.6 s to compile, ten times the function itself.
"""

from numba import njit
from numba.extending import overload, register_jitable

from fem.kernels.kernel_cache import keep
from fem.kernels.kernel_folder import cache_folder

# Division follows IEEE 754 and raises nothing. Without numba's run-time memory: nothing is allocated (what would
# allocate does not compile), and arrays that the caller holds anyway are not counted, which would take a tenth of the
# time loop (https://github.com/numba/numba/issues/2350).
OPTIONS = {"error_model": "numpy", "_nrt": False, "no_cfunc_wrapper": True}
INLINED = {**OPTIONS, "forceinline": True}


def kernel(function=None, **options):
    """Compile a function of arrays, named tuples of them and scalars for calls from Python and from other kernels."""
    if function is None:
        return lambda wrapped: kernel(wrapped, **options)
    return keep(njit(**OPTIONS, **options)(function), cache_folder())


def part(function=None, *, inlined: bool = True):
    """A function that kernels call: inlined where it is called, or compiled once in each of them."""
    if function is None:
        return lambda wrapped: part(wrapped, inlined=inlined)
    return register_jitable(**(INLINED if inlined else OPTIONS))(function)


def verb(function):
    """A part whose code depends on the type of its first argument, a named tuple; `functools.singledispatch` for parts.

    `@function.of(Type)` gives the code for one type. The function itself says what all of them do, and is the code for
    types that have none of their own.
    """
    known = {}

    def of(*kinds):
        def register(code):
            known.update(dict.fromkeys(kinds, code))
            return code

        return register

    @overload(function, jit_options=INLINED, strict=False)
    def choose(first, *_):
        return known.get(getattr(first, "instance_class", None), function)

    function.of = of
    return function


def every(one, *kinds):
    """The part that calls `one(pair, *arguments)` for every pair of groups of pairs, in order; of some kinds alone.

    The pairs of a group are of one type and share their code: two copies would crowd the instruction cache. Bodies in
    groups of one type are called in the same way.
    """

    def on_every(groups, *arguments):
        raise NotImplementedError("a part of kernels")

    @overload(on_every, jit_options=INLINED, strict=False)
    def choose(groups, *arguments):
        # written out: a function more, or arguments packed into a tuple, would take a second to compile
        names = ", ".join(f"a{i}" for i in range(len(arguments)))
        called = [i for i, group in enumerate(groups) if not kinds or group.dtype.instance_class in kinds]
        loops = [f"    for pair in groups[{i}]:\n        one(pair, {names})\n" for i in called]
        found = {"one": one}
        exec(f"def code(groups, {names}):\n    pass\n" + "".join(loops), found)
        return found["code"]

    return on_every
