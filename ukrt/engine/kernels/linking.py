"""Kernels are optimised once, in the module of the function that a host or Python calls.

Enters a Python function, leaves a `Kernel`. Numba by itself makes every function whole: it links the optimised modules
of all callees into it, optimises and translates everything again and adds two functions for callers in Python, so that
what stands n calls deep is compiled n times. Here what one kernel calls is only a *part*: its unoptimised module is
kept, and a *whole* (a C function, or a kernel that Python calls) links each part below it once. The front end, which
makes LLVM of Python, runs once per kernel and process.

Numba's compiler is meant to be given other passes (``pipeline_class``); what goes beyond that is that a library's
``_linking_libraries`` and ``_final_module`` are read here. `tests/engine/test_linking.py` is the first to notice if
Numba moves them.
"""

import functools
import sys

from numba import _dynfunc, types
from numba.core import compiler
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NativeLowering, NopythonRewrites
from numba.core.untyped_passes import InlineClosureLikes
from numba.extending import models, register_model

from ukrt.engine.kernels.lowering import ShortLower
from ukrt.engine.kernels.typing import RememberingContext


class _Part(JITCodeLibrary):
    """The unoptimised module of one kernel; it knows which others it needs."""

    def finalize(self):
        self._finalized = True  # nothing to do: no passes, no machine code

    def own_module(self):
        """This kernel alone, fit for being linked any number of times."""
        return super()._get_module_for_linking()

    def _get_module_for_linking(self):
        """With all that it needs, for a function of Numba's own kind that calls it."""
        module = self.own_module().clone()
        for library in _all_needed(self):
            whole = not isinstance(library, _Part)
            module.link_in(library._get_module_for_linking() if whole else library.own_module(), preserve=True)
        return module


class _Whole(JITCodeLibrary):
    """A library with one module for everything below it."""

    def finalize(self):
        needed = _all_needed(self)
        for part in needed:
            if isinstance(part, _Part):
                self._final_module.link_in(part.own_module(), preserve=True)
        self._linking_libraries = [library for library in needed if not isinstance(library, _Part)]
        super().finalize()


def _all_needed(library):
    """Every library that ``library`` needs, each once; what is no part brings along what it needs itself."""
    found, waiting = {}, [library]
    while waiting:
        for needed in waiting.pop()._linking_libraries:
            if needed not in found:
                found[needed] = None
                if isinstance(needed, _Part):
                    waiting.append(needed)
    return list(found)


@register_pass(mutates_CFG=True, analysis_only=False)
class _LowerPart(NativeLowering):
    """Make LLVM of a kernel for other kernels, and stop there."""

    _name = "lower_part_of_ukrt"
    lowering_class = ShortLower

    def run_pass(self, state):
        state["library"] = _Part(state.targetctx.codegen(), state.func_id.func_qualname)
        state.targetctx = state.targetctx.subtarget(enable_nrt=False)  # nothing is allocated: no references to count
        state.flags.no_compile = state.flags.no_cpython_wrapper = state.flags.no_cfunc_wrapper = True
        done = super().run_pass(state)
        # Numba knows compiled functions by an object of this kind. Nobody calls this one: its address is 0.
        lowered = state["cr"]
        key = _dynfunc.make_function(sys.modules[__name__], lowered.fndesc.qualname, "", 0, lowered.env, ())
        state.targetctx.insert_user_function(key, lowered.fndesc, [state["library"]])
        state["cr"] = lowered._replace(cfunc=key)
        return done


@register_pass(mutates_CFG=True, analysis_only=False)
class _LowerWhole(NativeLowering):
    """Make machine code of a function and of all that it needs."""

    _name = "lower_whole_of_ukrt"

    def run_pass(self, state):
        state["library"] = _Whole(state.targetctx.codegen(), state.func_id.func_qualname)
        state["library"].enable_object_caching()
        return super().run_pass(state)


# What kernels never hold: functions inside functions, and expressions of whole arrays.
_IDLE = (InlineClosureLikes, NopythonRewrites)


@functools.cache
def _remembering(context):
    return RememberingContext(context)


def _pipeline(lowering):
    """Numba's usual passes with another one at the end."""

    class Pipeline(compiler.CompilerBase):
        def __init__(self, typingctx, *rest):
            super().__init__(typingctx, *rest)
            self.state.typingctx = _remembering(typingctx)
            self.state.targetctx = self.state.targetctx.subtarget(typing_context=self.state.typingctx)

        def define_pipelines(self):
            manager = compiler.DefaultPassBuilder.define_nopython_pipeline(self.state)
            passes = [(lowering if one is NativeLowering else one, why) for one, why in manager.passes]
            manager.passes = [(one, why) for one, why in passes if one not in _IDLE]
            manager.finalize()
            return [manager]

    return Pipeline


Parts, Wholes = _pipeline(_LowerPart), _pipeline(_LowerWhole)


class _PartType(types.Dispatcher):
    """What kernels see of a kernel. A constant argument gets no code of its own: inlining sees the constant anyway."""

    def get_call_type(self, context, args, kws):
        return super().get_call_type(context, [types.unliteral(a) for a in args], kws)


register_model(_PartType)(models.OpaqueModel)


class Kernel:
    """A compiled function.

    Parameters
    ----------
    part, whole : numba dispatcher
        Compiled by `Parts`, for other kernels; by `Wholes`, for calls from Python.
    """

    def __init__(self, part, whole):
        self.part, self.whole = part, whole
        self._numba_type_ = _PartType(part)
        self.__name__, self.__doc__ = part.__name__, part.__doc__

    def __call__(self, *args):
        return self.whole(*args)
