# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The decorator of kernels: each kernel is a module of its own, without derivatives, and can run in parts on a CPU.

A kernel in a module of its own is compiled again only if the kernel itself changes. By default Warp also compiles the
derivative of each kernel. StitchMesh does not use derivatives, and compiling them takes longer than compiling the
kernel itself.

A kernel with arguments of ``Any`` type is compiled for each combination of types. Warp keeps all combinations of a
kernel in the module of the kernel, and compiles all of them again when one more is launched. ``for_arguments`` makes
each combination a kernel of its own instead, so that it is compiled once.

On a CPU, Warp runs a launch as one loop over all elements. Several threads can share a launch only if the loop can run
over a part of the elements. This module therefore changes one line of the C++ text from which Warp makes the loop: a
launch runs the last ``size`` elements of its ``shape``. In an ordinary launch these are all elements, so that no other
user of Warp notices the change. A launch of the elements from a to b has the shape b and the size b - a. The code for a
GPU does not change.
"""

from __future__ import annotations

import functools
import types
from collections.abc import Callable
from typing import Any

import warp as wp
from warp._src import codegen
from warp._src.types import get_signature

_ALL_ELEMENTS = "for (size_t task_index = 0; task_index < dim->size; ++task_index)"
_LAST_ELEMENTS = """size_t tasks = dim->coord_mult;
    for (size_t extent : dim->shape)
        tasks *= extent;
    for (size_t task_index = tasks - dim->size; task_index < tasks; ++task_index)"""

RUNS_IN_PARTS: bool = _ALL_ELEMENTS in codegen.cpu_module_template_forward
"""Whether this version of Warp makes the loop as expected; otherwise a launch runs on one thread."""
_MARK = " -DSTITCHMESH_RUNS_IN_PARTS" if RUNS_IN_PARTS else ""
"""Compiler flag without effect; it tells these kernels from kernels with Warp's own loop that Warp may have stored."""

codegen.cpu_module_template_forward = codegen.cpu_module_template_forward.replace(_ALL_ELEMENTS, _LAST_ELEMENTS)

_FLAGS = "-march=native" if wp.config.cpu_compiler_flags is None else wp.config.cpu_compiler_flags


def kernel(
    function: Callable[..., Any] | None = None, *, tile: int | None = 0, **options: Any
) -> Any:
    """Declare a kernel; this decorator replaces ``wp.kernel``.

    Args:
        function: the function of the kernel.
        tile: threads of a block on a GPU, for a kernel whose blocks share work; 0 for a kernel of single elements, and
            None for a kernel that runs on a CPU only.
        options: options of ``wp.kernel``.
    """
    if function is None:
        return functools.partial(kernel, tile=tile, **options)
    made = wp.kernel(
        function, module="unique", enable_backward=False, module_options={"cpu_compiler_flags": _FLAGS + _MARK},
        **options,
    )  # fmt: skip
    made.tile = tile
    made.declared_options = options
    return made


def for_arguments(generic: wp.Kernel, arguments: list[Any]) -> wp.Kernel:
    """Return the kernel for arguments of these types; a kernel without ``Any`` is returned as it is."""
    return concrete_kernel(generic, generic.infer_argument_types(arguments)) if generic.is_generic else generic


def concrete_kernel(generic: wp.Kernel, argument_types: list[Any]) -> wp.Kernel:
    """Return the kernel for arguments of these types, of a kernel with ``Any``."""
    known = generic.get_overload(argument_types)
    if known is None:
        function = functools.update_wrapper(_copied(generic.func), generic.func)
        function.__annotations__ = {**dict(zip(generic.adj.arg_types, argument_types, strict=True)), "return": None}
        known = kernel(function, tile=generic.tile, **generic.declared_options)
        generic.overloads[get_signature(argument_types)] = known
    return known


def _copied(function: types.FunctionType) -> types.FunctionType:
    return types.FunctionType(
        function.__code__, function.__globals__, function.__name__, function.__defaults__, function.__closure__
    )
