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
from collections.abc import Callable
from contextlib import suppress
from functools import cache, cached_property
from pathlib import Path

import numba
from llvmlite.binding import parse_bitcode
from numba import njit, types

from fem.kernels import numba_private as private
from fem.kernels.kernel_folder import cache_folder, notices
from fem.kernels.part_compiler import KernelCompiler, callees, fields_used, narrowed, shifted
from lagrange.files.output import read_sealed, write_sealed

GENERATED = "<every>"  # file of functions that `every` writes
# Division follows IEEE 754 and raises nothing. Without numba's run-time memory: nothing is allocated (what would
# allocate does not compile), and arrays that the caller holds anyway are not counted, which would take a tenth of the
# time loop (https://github.com/numba/numba/issues/2350).
OPTIONS = {"error_model": "numpy", "_nrt": False, "no_cfunc_wrapper": True}


# code of parts


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


class PartCompiler(KernelCompiler):
    """The kernels' compiler without machine code at its end."""

    def define_pipelines(self):
        (manager,) = super().define_pipelines()
        manager.passes = [
            (_PartLowering if each is private.NativeLowering else each, name) for each, name in manager.passes
        ]
        manager.finalize()
        return [manager]


def entry_point(description, environment, library):
    """The object that stands for a compiled function in numba; not to be called."""
    module, name = description.lookup_module(), description.qualname
    return private._dynfunc.make_function(module, name, "", 0, environment, (library,))


# what is kept on disk


class KernelCache(private._Cache):
    """What numba asks for compiled code and gives it to, of one function."""

    _ending = ".nbc"
    _reduced, _rebuilt = staticmethod(private.CompileResult._reduce), staticmethod(private.CompileResult._rebuild)

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
            write_sealed(self._file(key), private.dumps((key, self._reduced(compiled))))

    def _key(self, signature, codegen) -> tuple:
        function, code = self._function, self._function.__code__
        closure = [cell.cell_contents for cell in function.__closure__ or ()]
        text = _file_digest(code.co_filename) if code.co_filename != GENERATED else function.__doc__
        magic, inside = codegen.magic_tuple(), _digest(private.dumps(closure))
        return numba.__version__, signature, magic, text, code.co_firstlineno, inside

    def _file(self, key: tuple) -> Path:
        name = f"{self._function.__module__}.{self._function.__qualname__}".replace("<", "").replace(">", "")
        return self._folder / f"{name[-150:]}-{_digest(repr(key).encode())[:24]}{self._ending}"

    def enable(self) -> None:
        """Numba asks for it; nothing here is ever switched off."""

    disable = flush = enable


class PartCache(KernelCache):
    """The same of a part: without machine code."""

    _ending = ".part.nbc"  # a test may call a part as a kernel

    @staticmethod
    def _reduced(compiled) -> tuple:
        library, description = compiled.library, compiled.fndesc
        description.typemap = description.calltypes = None
        return library.name, library._final_module.as_bitcode(), description, compiled.environment, compiled.signature

    @staticmethod
    def _rebuilt(context, name, code, description, environment, signature):
        library = PartLibrary(context.codegen(), name)
        library._final_module = parse_bitcode(code)
        library._finalize_final_module()
        return private.compile_result(
            typing_context=context.typing_context, target_context=context, signature=signature, objectmode=False,
            entry_point=entry_point(description, environment, library), fndesc=description, library=library,
            environment=environment, reload_init=(),
        )  # fmt: skip


@cache
def _file_digest(path: str) -> str:
    return _digest(Path(path).read_bytes())


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _kept(kind: type[KernelCache], function, **options):
    """A function that numba compiles, kept in the folder of kernels if there is one."""
    found, folder = njit(**OPTIONS, **options)(function), cache_folder()
    if folder is not None and isinstance(found, private.Dispatcher):  # it is none where numba is switched off
        found._cache = kind(function, folder)
    return found


# kernels and parts


def kernel(function=None, **options):
    """Compile a function of arrays, named tuples of them and scalars for calls from Python and from other kernels."""
    if function is None:
        return lambda wrapped: kernel(wrapped, **options)
    return _kept(KernelCache, function, pipeline_class=KernelCompiler, **options)


def part(function=None, *, inlined: bool = True):
    """A function that kernels call: inlined where it is called, or compiled once in each of them."""
    if function is None:
        return lambda wrapped: part(wrapped, inlined=inlined)
    code = Code(function, inlined)
    _register(function, lambda *_: code)
    return function


class Code:
    """A function as the code of a part."""

    def __init__(self, function: Callable, inlined: bool):
        self._function, self._inlined = function, inlined

    @cached_property
    def _dispatcher(self):
        options = {"forceinline": True} if self._inlined else {}
        return _kept(PartCache, self._function, pipeline_class=PartCompiler, no_cpython_wrapper=True, **options)

    def compiled(self, arguments, keywords):
        """Signature and entry point for arguments of some types."""
        python, arguments = self._dispatcher._compiler.fold_argument_types(arguments, keywords)
        kinds = tuple(map(narrowed, arguments, fields_used(self._function)))
        self._dispatcher.compile(kinds)
        found = self._dispatcher.overloads[kinds]
        return found.signature.replace(pysig=python), found.entry_point


def _register(function: Callable, choose: Callable) -> None:
    """Let kernels call a function: `choose` gives the `Code` for types of arguments."""
    callees[function] = function

    class _Template(private.AbstractTemplate):
        key = function

        def generic(self, arguments, keywords):
            signature, self._entry = choose(*arguments).compiled(arguments, keywords)
            return signature

        def get_impl_key(self, signature):
            return self._entry

    private.infer_global(function, types.Function(_Template))


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
        calls = [_calls(kinds, body, i, names) for i, body in enumerate(bodies)]
        # written out: a function more, or arguments packed into a tuple, would take a second to compile
        text = f"def code(bodies, {names}):\n    pass\n" + "".join(calls)
        if text not in codes:
            found = {"one": one, "__name__": one.__module__}  # a kept function is of a module that can be found
            exec(compile(text, GENERATED, "exec"), found)
            code = found["code"]
            code.__doc__ = text
            code.__qualname__ = ".".join(["every", one.__module__, one.__qualname__])
            shifted[code] = one
            codes[text] = Code(code, True)
        return codes[text]

    shifted[on_every] = one
    _register(on_every, choose)
    return on_every


def _calls(kinds: tuple, body, i: int, names: str) -> str:
    """Lines that call `one` for entry i of a tuple: a body, nothing, or a group of pairs."""
    is_group = isinstance(body, types.BaseTuple) and not isinstance(body, types.BaseNamedTuple)
    if kinds and (body.dtype if is_group else body).instance_class not in kinds:
        return ""
    if is_group:
        return f"    for pair in bodies[{i}]:\n        one(pair, {names})\n"
    return f"    one(bodies[{i}], {names})\n"
