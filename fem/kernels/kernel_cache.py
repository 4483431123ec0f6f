"""Compiled kernels on disk: a sealed file for each function, signature and processor, for numba to load.

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
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.dispatcher import Dispatcher
from numba.core.serialize import dumps

from fem.kernels.kernel_folder import remarks
from lagrange.sealed import read_sealed, write_sealed


def keep(function, folder: Path | None):
    """Keep what numba compiles of a function in a folder; None: nowhere."""
    if folder is not None and isinstance(function, Dispatcher):  # it is none where numba is switched off
        function._cache = KernelCache(function.py_func, folder)
    return function


class KernelCache(_Cache):
    """What numba asks for compiled code and gives it to, of one function."""

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
            data = read_sealed(self._file(key))
            kept_key, parts = pickle.loads(data) if data is not None else (None, None)
            if kept_key == key:  # names are shortened digests of keys
                return CompileResult._rebuild(context, *parts)
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
            _remark(f"{self._folder}: compiled kernels there were damaged and have been compiled anew")
        if compiled.library.has_dynamic_globals:  # addresses of this process
            return
        key = self._key(signature, compiled.codegen)
        with suppress(OSError):
            write_sealed(self._file(key), dumps((key, compiled._reduce())))

    def _key(self, signature, codegen) -> tuple:
        code = self._function.__code__
        closure = [cell.cell_contents for cell in self._function.__closure__ or ()]
        text = _file_digest(code.co_filename)
        return numba.__version__, signature, codegen.magic_tuple(), text, code.co_firstlineno, _digest(dumps(closure))

    def _file(self, key: tuple) -> Path:
        name = f"{self._function.__module__}.{self._function.__qualname__}".replace("<", "").replace(">", "")
        return self._folder / f"{name[-150:]}-{_digest(repr(key).encode())[:24]}.nbc"

    def enable(self) -> None:
        """Numba asks for it; nothing here is ever switched off."""

    disable = flush = enable


def _remark(sentence: str) -> None:
    if sentence not in remarks:
        remarks.append(sentence)


@cache
def _file_digest(path: str) -> str:
    return _digest(Path(path).read_bytes())


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
