"""How parts are typed and compiled: for the fields that they use, once for all kernels, and without machine code."""

from collections.abc import Callable
from functools import cached_property

from llvmlite.binding import parse_bitcode
from numba import _dynfunc, njit, types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import compile_result
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NativeLowering
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.extending import lower_cast, models, register_model

from fem.kernels.fields_used import WHOLE, Used, callees, fields_used, forget
from fem.kernels.known_none import UNUSED, KernelCompiler, UnusedType


@register_model(UnusedType)
class _UnusedModel(models.StructModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, [])


def narrowed(given: types.Type, used: Used) -> types.Type:
    """The type with all fields unused but some."""
    if used is WHOLE or not isinstance(given, types.BaseNamedTuple):
        return given
    kinds = [narrowed(t, used[f]) if f in used else UNUSED for f, t in zip(given.fields, given, strict=True)]
    return types.BaseTuple.from_types(kinds, given.instance_class)


@lower_cast(types.Any, UnusedType)
def _leave_out(context, builder, given, wanted, value):
    return context.get_constant_undef(wanted)


@lower_cast(types.BaseNamedTuple, types.BaseNamedTuple)
def _narrow(context, builder, given, wanted, value):
    narrow = context.get_constant_undef(wanted)
    for i, kinds in enumerate(zip(given, wanted, strict=True)):
        if kinds[1] != UNUSED:
            field = context.cast(builder, builder.extract_value(value, i), *kinds)
            narrow = builder.insert_value(narrow, field, i)
    return narrow


class PartLibrary(JITCodeLibrary):
    """LLVM's code of a part, for kernels to inline."""

    def _optimize_final_module(self):
        """Kernels do it."""

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class _PartLowering(NativeLowering):
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


def entry_point(description, environment, library):
    """The object that stands for a compiled function in numba; not to be called."""
    return _dynfunc.make_function(description.lookup_module(), description.qualname, "", 0, environment, (library,))


def reduced(compiled) -> tuple:
    """What is kept of a compiled part."""
    library, description = compiled.library, compiled.fndesc
    description.typemap = description.calltypes = None
    return library.name, library._final_module.as_bitcode(), description, compiled.environment, compiled.signature


def rebuilt(context, name, code, description, environment, signature):
    """The compiled part of what `reduced` has kept."""
    library = PartLibrary(context.codegen(), name)
    library._final_module = parse_bitcode(code)
    library._finalize_final_module()
    return compile_result(
        typing_context=context.typing_context,
        target_context=context,
        entry_point=entry_point(description, environment, library),
        signature=signature,
        objectmode=False,
        fndesc=description,
        library=library,
        environment=environment,
        reload_init=(),
    )


class PartCompiler(KernelCompiler):
    """The kernels' compiler without machine code at its end."""

    def define_pipelines(self):
        (manager,) = super().define_pipelines()
        manager.passes = [(_PartLowering if each is NativeLowering else each, name) for each, name in manager.passes]
        manager.finalize()
        return [manager]


class Code:
    """A function as the code of a part."""

    def __init__(self, function: Callable, options: dict, keep: Callable):
        self._function, self._options, self._keep = function, options, keep

    @cached_property
    def _dispatcher(self):
        wrappers = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        return self._keep(njit(pipeline_class=PartCompiler, **{**self._options, **wrappers})(self._function))

    def compiled(self, arguments, keywords):
        """Signature and entry point for arguments of some types."""
        python, arguments = self._dispatcher._compiler.fold_argument_types(arguments, keywords)
        kinds = tuple(map(narrowed, arguments, fields_used(self._function)))
        self._dispatcher.compile(kinds)
        found = self._dispatcher.overloads[kinds]
        return found.signature.replace(pysig=python), found.entry_point


def register(function: Callable, choose: Callable, codes: Callable, of=types.Type) -> None:
    """Let kernels call a function: `choose` gives the `Code` for types of arguments, `codes` all that it may give.

    `of` : a kind of types that one argument has; of others it is whatever numba makes of the function
    """
    callees[function] = codes
    forget()

    class _Template(AbstractTemplate):
        key = function

        def generic(self, arguments, keywords):
            if arguments and not any(isinstance(each, of) for each in arguments):
                return None
            signature, self._entry = choose(*arguments).compiled(arguments, keywords)
            return signature

        def get_impl_key(self, signature):
            return self._entry

    infer_global(function, types.Function(_Template))
