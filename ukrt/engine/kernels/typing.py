"""Type inference that remembers what it has found out about functions of numbers and arrays.

Enters Numba's typing context, leaves one that shares its whole state and gives the same types. Numba asks each of the
dozens of implementations of ``+`` or ``x[k]`` anew at every place where one stands, once to infer types and again to
make code of it; kernels write such things twenty thousand times, of four hundred kinds.
"""

import functools

from numba import types
from numba.core.errors import TypingError
from numba.core.typing import Context
from numba.extending import models, register_model

_PLAIN = (types.Number, types.Boolean, types.Literal, types.Omitted, types.Array)  # whose answers cannot change


class _Remembering(types.Function):
    """One of Numba's functions, the same but for its memory."""

    def __init__(self, templates):
        super().__init__(templates)
        self._known = {}

    def get_call_type(self, context, args, kws):
        plain = not kws and all(isinstance(a, _PLAIN) for a in args)
        if not plain:
            return super().get_call_type(context, args, kws)
        key = tuple(args)
        if key not in self._known:
            try:
                self._known[key] = super().get_call_type(context, args, kws)
            except TypingError as error:
                self._known[key] = error
        if isinstance(self._known[key], TypingError):
            raise self._known[key].with_traceback(None)
        return self._known[key]


register_model(_Remembering)(models.OpaqueModel)
_remembering = functools.cache(_Remembering)  # kept: Numba forgets a type that is not used for a while


class RememberingContext(Context):
    """A typing context whose functions remember.

    Parameters
    ----------
    context : numba.core.typing.Context
        Whose state is shared.
    """

    def __init__(self, context):
        self.__dict__ = context.__dict__

    def _lookup_global(self, gv):
        found = super()._lookup_global(gv)
        return _remembering(found.templates) if type(found) is types.Function else found
