"""LLVM of a kernel, as Numba makes it but in fewer words: what stands there most often, ``x[k]``, is spelled short.

Enters Numba's typed form of a kernel, leaves LLVM. Numba's own way to an element takes an array to pieces on the stack,
for any number of dimensions, and counts references; all of that is optimised away later, at some cost.
"""

from llvmlite import ir
from numba import types
from numba.core.lowering import Lower


def _is_plain(signature):
    """Whether ``signature`` is that of one number in a flat array at an integer."""
    array, index, *value = signature.args
    flat = isinstance(array, types.Array) and array.ndim == 1 and array.layout == "C" and array.aligned
    plain = flat and isinstance(array.dtype, (types.Integer, types.Float)) and types.unliteral(index) == types.int64
    return plain and all(isinstance(types.unliteral(v), (types.Integer, types.Float)) for v in value)


class ShortLower(Lower):
    """Numba's lowering for functions that hold no references."""

    def _element(self, array_var, index_var, signature):
        """The address of an element; negative indices count from the end, as ever."""
        kind, array = signature.args[0], self.loadvar(array_var.name)
        model, builder = self.context.data_model_manager[kind], self.builder
        index = self.context.cast(builder, self.loadvar(index_var.name), self.typeof(index_var.name), types.int64)
        literal = self.typeof(index_var.name)
        if not (isinstance(literal, types.Literal) and literal.literal_value >= 0):
            length = builder.extract_value(model.get(builder, array, "shape"), 0)
            negative = builder.icmp_signed("<", index, ir.Constant(index.type, 0))
            index = builder.select(negative, builder.add(index, length), index)
        return builder.gep(model.get(builder, array, "data"), [index])

    def lower_getitem(self, resty, expr, value, index, signature):
        if not _is_plain(signature):
            return super().lower_getitem(resty, expr, value, index, signature)
        item = self.builder.load(self._element(value, index, signature))
        return self.context.cast(self.builder, item, signature.args[0].dtype, resty)

    def lower_setitem(self, target_var, index_var, value_var, signature):
        if not _is_plain(signature):
            return super().lower_setitem(target_var, index_var, value_var, signature)
        value, kind = self.loadvar(value_var.name), self.typeof(value_var.name)
        value = self.context.cast(self.builder, value, kind, signature.args[2])
        value = self.context.cast(self.builder, value, signature.args[2], signature.args[0].dtype)
        self.builder.store(value, self._element(target_var, index_var, signature))
        return self.context.get_dummy_value()

    def delvar(self, name):
        """Nothing: there is no reference to give back."""
