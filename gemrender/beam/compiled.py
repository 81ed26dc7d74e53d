"""What the compiled kernels are made with: the decorator, and arithmetic that carries derivatives.

The polygons' kernel is written once and compiled twice, for float64 and for complex128. In the latter each
number's imaginary part is `STEP` times its derivative by a parameter: the complex step (Squire & Trapp, SIAM
Review 40, 110 (1998)), exact to rounding because nothing is subtracted. Decisions look at real parts only.

For who changes a kernel: all of them are compiled anew when any file of this folder has changed (`cache`).
"""

from __future__ import annotations

import cmath
import contextlib
import math
import threading
from collections.abc import Callable
from typing import Any

import numba
from numba.core import config, types
from numba.core.codegen import get_host_cpu_features
from numba.extending import intrinsic, overload

from gemrender.beam.budget import PAUSED
from gemrender.beam.cache import KernelCache

__all__ = [
    "COMPILING",
    "STEP",
    "bits",
    "is_dual",
    "jit",
    "jit_fast",
    "jit_inner",
    "jit_with_arrays",
    "real",
    "root",
]

#: Imaginary part that stands for a derivative of 1: its square is nothing beside any real part.
STEP = 1e-30

#: Without numba's count of who holds an array, which takes two locked instructions for each slice and each
#: argument: half of the time that polygons took. Who makes an array needs it.
_UNCOUNTED = {"_nrt": False}
_INNER = {**_UNCOUNTED, "no_cpython_wrapper": True}
#: Held by who compiles or loads a kernel, or has numba refresh what it knows: where two threads do, it fails.
COMPILING = threading.RLock()


def _prefer_wide_vectors() -> None:
    """Let numba use vectors of 512 bits where the processor has them: LLVM takes half of that by default.

    Rays are followed half as fast again. Holds for all of the process that is compiled from now on; who has
    set NUMBA_CPU_FEATURES is not overruled.
    """
    features = get_host_cpu_features()
    if config.CPU_FEATURES is None and config.CPU_NAME is None and "+avx512f" in features.split(","):
        config.CPU_FEATURES = features + ",-prefer-256-bit"


_prefer_wide_vectors()


def jit(function: Callable[..., Any]) -> Any:
    """Compile a function when it is first called, and keep the result on disk where that can be written.

    It makes no arrays, but writes into those that it is given, item by item.
    """
    return _compile(function, **_UNCOUNTED)


def jit_with_arrays(function: Callable[..., Any]) -> Any:
    """Compile a function that makes arrays, or has numpy sum them up."""
    return _compile(function)


def jit_inner(function: Callable[..., Any]) -> Any:
    """Compile a function that only compiled ones call: without what Python would need to call it."""
    return _compile(function, **_INNER)


def jit_fast(function: Callable[..., Any]) -> Any:
    """Compile an inner function that never meets NaN, for vector instructions.

    Products and sums may be taken together (fused multiply-add), which changes last bits, and nothing more.
    """
    return _compile(function, fastmath={"nnan", "nsz", "contract"}, **_INNER)


def _compile(function: Callable[..., Any], **more: Any) -> Any:
    kernel = numba.njit(nogil=True, error_model="numpy", no_cfunc_wrapper=True, **more)(function)
    compiles = kernel._compile_for_args

    def one_at_a_time(*arguments: Any, **keywords: Any) -> Any:
        with COMPILING, PAUSED.compiling():
            return compiles(*arguments, **keywords)

    kernel._compile_for_args = one_at_a_time
    with contextlib.suppress(RuntimeError, OSError):  # no folder that a cache can be written to
        kernel._cache = KernelCache(function)
    return kernel


@intrinsic
def bits(_: Any, x: Any) -> Any:
    """Return the bits of a float64 as an int64."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], context.get_value_type(types.int64))

    return types.int64(types.float64), code


def real(x: Any) -> Any:
    """Return the value without its derivative."""
    return x.real


@overload(real)
def _real(x: Any) -> Any:
    def dual(x: Any) -> Any:
        return x.real

    def plain(x: Any) -> Any:
        return x

    return dual if isinstance(x, types.Complex) else plain


def is_dual(x: Any) -> bool:
    """Return whether numbers of an array carry derivatives."""
    return bool(x.dtype.kind == "c")


@overload(is_dual)
def _is_dual(x: Any) -> Any:
    def yes(x: Any) -> bool:
        return True

    def no(x: Any) -> bool:
        return False

    return yes if isinstance(x.dtype, types.Complex) else no


def root(x: Any) -> Any:
    """Return the square root of a positive number."""
    return cmath.sqrt(x)


@overload(root)
def _root(x: Any) -> Any:
    def dual(x: Any) -> Any:
        value = math.sqrt(x.real)
        return complex(value, 0.5 * x.imag / value if value > 0.0 else 0.0)

    def plain(x: Any) -> Any:
        return math.sqrt(x)

    return dual if isinstance(x, types.Complex) else plain
