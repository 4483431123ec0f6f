"""All that is used of numba beyond its documented interface.

`tests/test_compiling.py` tries each use by itself, so that a version of numba that changes one is named with it.
"""

# ruff: noqa: F401
from numba import _dynfunc
from numba.core import cgutils, config, consts, ir
from numba.core.analysis import dead_branch_prune
from numba.core.caching import _Cache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, CompileResult, DefaultPassBuilder, compile_result
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.dispatcher import Dispatcher
from numba.core.errors import TypingError
from numba.core.event import Listener, install_listener, install_recorder
from numba.core.ir_utils import build_definitions
from numba.core.serialize import dumps
from numba.core.typed_passes import NativeLowering
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.core.untyped_passes import DeadBranchPrune
