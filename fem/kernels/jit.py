"""How functions of the time loop are compiled: `@kernel`, `@part`, `every`; once per version of the code.

A `@kernel` is called from Python. A `@part` stands in the code of the kernels that call it and nowhere else: a function
that Python may call has code that takes apart every array of its arguments, which for those of the time loop takes
0.6 s to compile, ten times the function itself.

Compiled kernels on disk: a sealed file for each function, signature and processor, for numba to load.

What is kept is unpickled and run, so a folder in which others could have put something is not read. A damaged file is
compiled anew and replaced; where nothing can be written, nothing is kept. None of this ends a run, as it does with
numba's own cache, which would also write beside the modules, where a change of another module goes unseen.
"""

import hashlib
import pickle
from contextlib import suppress
from functools import cache
from pathlib import Path

import numba
from numba import njit

from fem.kernels.kernel_folder import cache_folder, notices
from fem.kernels.lanes import LanesType
from fem.kernels.numba_private import BaseNamedTuple, BaseTuple, CompileResult, Dispatcher, Float, _Cache, dumps
from fem.kernels.part_compiler import Code, KernelCompiler, rebuilt, reduced, register, shifted
from lagrange.files.output import read_sealed, write_sealed

GENERATED = "<every>"  # file of functions that `every` writes


def keep(function, folder: Path | None, cache: type["KernelCache"] | None = None):
    """Keep what numba compiles of a function in a folder; None: nowhere."""
    if folder is not None and isinstance(function, Dispatcher):  # it is none where numba is switched off
        function._cache = (cache or KernelCache)(function.py_func, folder)
    return function


class KernelCache(_Cache):
    """What numba asks for compiled code and gives it to, of one function."""

    _ending = ".nbc"

    def __init__(self, function, folder: Path):
        self._function, self._folder, self._damaged = function, folder, False

    @property
    def cache_path(self) -> str:
        return str(self._folder)

    def load_overload(self, signature, context):
        """The compiled function, or None where it must be compiled.

        Without the context's `refresh` that numba's own cache begins with: it imports all that a compiler knows, half a
        second for what is only loaded. Compilers refresh their context themselves.
        """
        key = self._key(signature, context.codegen())
        try:
            data = read_sealed(self._file(key), private=True)
            kept_key, parts = pickle.loads(data) if data is not None else (None, None)
            if kept_key == key:  # names are shortened digests of keys
                return self._rebuilt(context, *parts)
        except OSError:
            return None
        except Exception:  # sealed, and yet of another LLVM, say
            pass
        self._damaged = True
        return None

    def save_overload(self, signature, compiled) -> None:
        """Keep a compiled function, if that can be done."""
        if self._damaged:
            self._damaged = False
            sentence = f"{self._folder}: compiled kernels there were damaged and have been compiled anew"
            if sentence not in notices:
                notices.append(sentence)
        if compiled.library.has_dynamic_globals:  # addresses of this process
            return
        key = self._key(signature, compiled.codegen)
        with suppress(OSError):
            write_sealed(self._file(key), dumps((key, self._reduced(compiled))))

    _reduced, _rebuilt = staticmethod(CompileResult._reduce), staticmethod(CompileResult._rebuild)

    def _key(self, signature, codegen) -> tuple:
        function, code = self._function, self._function.__code__
        closure = [cell.cell_contents for cell in function.__closure__ or ()]
        text = _file_digest(code.co_filename) if code.co_filename != GENERATED else function.__doc__
        return numba.__version__, signature, codegen.magic_tuple(), text, code.co_firstlineno, _digest(dumps(closure))

    def _file(self, key: tuple) -> Path:
        name = f"{self._function.__module__}.{self._function.__qualname__}".replace("<", "").replace(">", "")
        return self._folder / f"{name[-150:]}-{_digest(repr(key).encode())[:24]}{self._ending}"

    def enable(self) -> None:
        """Numba asks for it; nothing here is ever switched off."""

    disable = flush = enable


class PartCache(KernelCache):
    """The same of a part: without machine code."""

    _ending = ".part.nbc"  # a test may call a part as a kernel
    _reduced, _rebuilt = staticmethod(reduced), staticmethod(rebuilt)


@cache
def _file_digest(path: str) -> str:
    return _digest(Path(path).read_bytes())


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


# Division follows IEEE 754 and raises nothing. Without numba's run-time memory: nothing is allocated (what would
# allocate does not compile), and arrays that the caller holds anyway are not counted, which would take a tenth of the
# time loop (https://github.com/numba/numba/issues/2350).
OPTIONS = {"error_model": "numpy", "_nrt": False, "no_cfunc_wrapper": True}
INLINED = {**OPTIONS, "forceinline": True}


def kernel(function=None, **options):
    """Compile a function of arrays, named tuples of them and scalars for calls from Python and from other kernels."""
    if function is None:
        return lambda wrapped: kernel(wrapped, **options)
    return keep(njit(pipeline_class=KernelCompiler, **OPTIONS, **options)(function), cache_folder())


def _keep_part(function):
    return keep(function, cache_folder(), PartCache)


def part(function=None, *, inlined: bool = True):
    """A function that kernels call: inlined where it is called, or compiled once in each of them."""
    if function is None:
        return lambda wrapped: part(wrapped, inlined=inlined)
    code = Code(function, INLINED if inlined else OPTIONS, _keep_part)
    register(function, lambda *_: code, function)
    return function


def lanes_call(function, code) -> None:
    """Let kernels call one of numpy's functions on lanes, and on scalars what numba can't: `code` does the same."""
    chosen = Code(code, INLINED, _keep_part)
    register(function, lambda *_: chosen, code, LanesType | Float)


def every(one, *kinds):
    """The part that calls `one(body, *arguments)` for every body of a tuple, or for those of some kinds, in order.

    Of groups of pairs in place of bodies it is every pair of them. The pairs of a group are of one type and share their
    code: two copies would crowd the instruction cache.
    """
    codes = {}

    def on_every(bodies, *arguments):
        """What the code does, for a loop that is not compiled."""
        for body in bodies:
            group = body if type(body) is tuple else (body,)
            for pair in group:
                if not kinds or isinstance(pair, kinds):
                    one(pair, *arguments)

    def choose(bodies, *arguments):
        names = ", ".join(f"a{i}" for i in range(len(arguments)))
        calls = [_calls(one, kinds, body, i, names) for i, body in enumerate(bodies)]
        # written out: a function more, or arguments packed into a tuple, would take a second to compile
        text = f"def code(bodies, {names}):\n    pass\n" + "".join(calls)
        if text not in codes:
            found = {"one": one, "__name__": one.__module__}  # a kept function is of a module that can be found
            exec(compile(text, GENERATED, "exec"), found)
            code = found["code"]
            code.__doc__ = text
            code.__qualname__ = ".".join(["every", one.__module__, one.__qualname__])
            shifted[code] = one
            codes[text] = Code(code, INLINED, _keep_part)
        return codes[text]

    shifted[on_every] = one
    register(on_every, choose, on_every)
    return on_every


def _calls(one, kinds: tuple, body, i: int, names: str) -> str:
    """Lines that call `one` for entry i of a tuple: a body, nothing, or a group of pairs."""
    is_group = isinstance(body, BaseTuple) and not isinstance(body, BaseNamedTuple)
    if kinds and (body.dtype if is_group else body).instance_class not in kinds:
        return ""
    if is_group:
        return f"    for pair in bodies[{i}]:\n        one(pair, {names})\n"
    return f"    one(bodies[{i}], {names})\n"
