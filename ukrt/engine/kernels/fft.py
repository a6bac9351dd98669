"""A real FFT for convolution: blocks of n real samples in, n complex values in an order of its own out, and back.

It evaluates X(z) = sum x[k] z^k at the n roots of z^n = i (the "right-angle" transform). The product of two such
spectra is the product of the polynomials modulo z^n - i: with real inputs its real part is the first half of their
linear convolution and its imaginary part the second half. So n real samples need a complex transform of n points, no
zero padding to 2n points, no untangling, no special first bin. Decimation by radix 8 in place, twiddles a table in the
caller's array, every operation on vectors of eight doubles; forward and inverse agree on the permuted order, which
`fft_angles` of `fft_tables` tells. Sizes: powers of two from 64. The two last passes are one, in registers.

A pass divides z^(rm) - e^(i t) into r factors z^m - e^(i u), u = t/r + 2 pi j/r, by layers of (a + w b, a - w b). The
inverse carries no 1/n; put it into one of the factors of the product. Passes can be run in shares (units), so that a
caller may spread one transform over time.
"""

from ukrt.engine.kernels.fft_butterflies import (
    add_tiles,
    first2,
    first4,
    first8,
    forward8,
    from_tiles,
    inverse8,
    last2,
    last4,
    last8,
    real_to_tiles,
    to_tiles,
)
from ukrt.engine.kernels.fft_tables import NODE, place_of
from ukrt.engine.kernels.jit import inlined, kernel

fft_place = inlined(place_of)


# Passes, any share of one at a time --------------------------------------------------------------------------------
@kernel
def fft_first_pass(d, x, y, n, radix, table, start, stop):
    """Units ``start`` to ``stop`` (of n / 8 radix) of the first pass: n reals in a row at ``x``, points at ``y``."""
    stride, imag = n // radix, fft_place(n)
    for at in range(8 * start, 8 * stop, 8):
        if radix == 8:
            first8(d, x + at, y + fft_place(at), stride, imag, fft_place(stride), table)
        elif radix == 4:
            first4(d, x + at, y + fft_place(at), stride, imag, fft_place(stride), table)
        else:
            first2(d, x + at, y + fft_place(at), stride, imag, fft_place(stride), table)


@kernel
def fft_last_pass(d, x, y, second, n, radix, table, start, stop):
    """Units of the inverse's last pass: points at ``x``; adds the result's halves to ``y`` and ``second``, as points.

    Both halves have 8 doubles free after each 512, too.
    """
    stride, imag = fft_place(n // radix), fft_place(n)
    for unit in range(start, stop):
        at = fft_place(8 * unit)
        if radix == 8:
            last8(d, x + at, y + at, imag, second - y, stride, table)
        elif radix == 4:
            last4(d, x + at, y + at, imag, second - y, stride, table)
        else:
            last2(d, x + at, y + at, imag, second - y, stride, table)


@kernel
def fft_forward_pass(d, x, n, stride, table, start, stop):
    """Units (of n / 64) of a middle pass in place at ``x``: nodes of 8 ``stride`` points are divided by 8."""
    per_node, imag = stride // 8, fft_place(n)
    for unit in range(start, stop):
        node = unit // per_node
        at = x + fft_place(8 * stride * node) + fft_place(8 * (unit - per_node * node))
        forward8(d, at, at, imag, imag, fft_place(stride), table + NODE * node)


@kernel
def fft_inverse_pass(d, x, n, stride, table, start, stop):
    """Units of the pass that undoes `fft_forward_pass` (eight times too large)."""
    per_node, imag = stride // 8, fft_place(n)
    for unit in range(start, stop):
        node = unit // per_node
        at = x + fft_place(8 * stride * node) + fft_place(8 * (unit - per_node * node))
        inverse8(d, at, at, imag, imag, fft_place(stride), table + NODE * node)


@kernel
def fft_to_tiles(d, x, y, n, stride, table, start, stop):
    """Units (of n / 64) of the forward's last two passes: points at ``x`` to tiles ``stride`` apart at ``y``."""
    for unit in range(start, stop):
        at = x + fft_place(64 * unit)
        to_tiles(d, at, y + 8 * stride * unit, fft_place(n), 8, stride, table + 9 * NODE * unit)


@kernel
def fft_from_tiles(d, x, y, n, stride, table, start, stop):
    """Units of the inverse's first two passes: tiles ``stride`` apart at ``x`` to points at ``y``."""
    for unit in range(start, stop):
        at = y + fft_place(64 * unit)
        from_tiles(d, x + 8 * stride * unit, at, 8, fft_place(n), stride, table + 9 * NODE * unit)


@kernel
def fft_forward_64(d, x, y, stride, table):
    """A whole transform of 64 reals at ``x`` to tiles ``stride`` apart at ``y``."""
    real_to_tiles(d, x, y, 0, 8, stride, table)


@kernel
def fft_inverse_64_add(d, x, y, second, stride, table):
    """Tiles ``stride`` apart at ``x`` to 128 reals, 64 times too large, added to what is at ``y`` and ``second``."""
    add_tiles(d, x, y, 8, second - y, stride, table)


# Whole transforms --------------------------------------------------------------------------------------------------
@kernel
def fft_forward(d, x, work, y, n, radix, table):
    """n reals at ``x`` to n / 8 tiles (8 real, 8 imaginary parts) in a row at ``y``; ``work`` holds 2 `fft_place` (n).

    ``radix`` is the first pass's, ``table`` the offset of `fft_tables.fft_table`'s numbers.
    """
    if n == 64:
        fft_forward_64(d, x, y, 16, table)
        return
    fft_first_pass(d, x, work, n, radix, table, 0, n // (8 * radix))
    nodes, stride = radix, n // radix // 8
    table += NODE
    while stride > 8:
        fft_forward_pass(d, work, n, stride, table, 0, n // 64)
        table += NODE * nodes
        nodes, stride = 8 * nodes, stride // 8
    fft_to_tiles(d, work, y, n, 16, table, 0, n // 64)


@kernel
def fft_inverse_add(d, y, work, x, n, radix, table):
    """Tiles at ``y`` to 2 n reals, n times too large, added to those at `fft_place` of ``x``; ``work`` as above."""
    if n == 64:
        fft_inverse_64_add(d, y, x, x + 64, 16, table)
        return
    first, table = table, table + NODE
    nodes, stride = radix, n // radix // 8
    while stride > 8:
        table += NODE * nodes
        nodes, stride = 8 * nodes, stride // 8
    fft_from_tiles(d, y, work, n, 16, table, 0, n // 64)
    while nodes > radix:
        nodes, stride = nodes // 8, n // nodes
        table -= NODE * nodes
        fft_inverse_pass(d, work, n, stride, table, 0, n // 64)
    fft_last_pass(d, work, x, x + fft_place(n), n, radix, first, 0, n // (8 * radix))
