"""Kernels are compiled once, where they are called: what Numba is asked to do differently, and what it gives."""

import numba
import numpy as np
import pytest

from ukrt.engine.kernels.jit import kernel


@kernel
def _lowest(x, first):
    total = 0.0
    for k in range(first, len(x)):
        total += x[k] * x[k]
    return total


@kernel
def _middle(x, scale):
    return scale * (_lowest(x, 0) + _lowest(x, len(x) // 2))


@kernel
def _upper(x):
    return _middle(x, 2.0) + _lowest(x, 1)


def _items(x, n, single, out):
    """Elements by every kind of index and value that kernels use."""
    k = len(x) - 1
    x[0], x[-1], x[-2] = x[k] + 1.0, n[-3], n[0]
    n[1], n[k - 2 - k] = 7, n[2] + 3
    single[np.int64(2)] = np.float32(x[1]) / np.float32(3.0)
    for j in range(np.uint64(1), np.uint64(3)):
        x[j] += single[j] * n[np.int32(j)]
    for j in range(-3, 0):
        out[j] = x[j] - n[j]
    n[0] = True
    return x[-k] + n[-1] + single[-1]


_kernel_of_items = kernel(_items)


@kernel
def _call_items(x, n, single, out):
    return _kernel_of_items(x, n, single, out)


@numba.njit
def _foreign(x):
    """A function of Numba's own kind."""
    return _upper(x) + 1.0


EXPECTED = 2.0 * (30.0 + 25.0) + 29.0  # of 1, 2, 3, 4


@pytest.fixture
def made_whole(monkeypatch):
    """Names of the libraries that were optimised and made machine code of."""
    names, finalize = [], numba.core.codegen.CPUCodeLibrary.finalize
    note = numba.core.codegen.CPUCodeLibrary
    monkeypatch.setattr(note, "finalize", lambda self: (names.append(self.name), finalize(self))[1])
    return names


def test_only_what_python_calls_is_made_whole(made_whole):
    assert _upper(np.arange(1.0, 5.0)) == EXPECTED
    assert set(_upper.whole.overloads) and not _middle.whole.overloads and not _lowest.whole.overloads
    assert not {"_middle", "_lowest"} & set(made_whole)


def test_a_constant_argument_makes_no_second_copy():
    _upper(np.arange(1.0, 5.0))
    _upper.part.compile("(float64[::1],)")
    assert len(_lowest.part.overloads) == 1  # called with 0, with 1 and with a variable


def test_functions_of_numbas_own_kind_may_call_kernels():
    assert _foreign(np.arange(1.0, 5.0)) == EXPECTED + 1.0


def test_a_kernel_without_the_compiler_is_a_function(monkeypatch):
    monkeypatch.setattr(numba.core.config, "DISABLE_JIT", 1)
    assert kernel(abs) is abs


@pytest.mark.parametrize("items", [_kernel_of_items, _call_items], ids=["whole", "part"])
def test_elements_are_those_of_python(items):
    def arrays():
        return np.arange(5.0) / 3.0, np.arange(3, 9), np.array([1.5, 2.5, 3.5], np.float32), np.zeros(4)

    expected, got = arrays(), arrays()
    assert items(*got) == _items(*expected)
    for one, other in zip(got, expected, strict=True):
        assert one.tobytes() == other.tobytes()
