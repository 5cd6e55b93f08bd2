# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The decorator of kernels: each kernel is a module of its own, without derivatives, and can run in parts on a CPU.

A kernel in a module of its own is compiled again only if the kernel itself changes. By default Warp also compiles the
derivative of each kernel. StitchMesh does not use derivatives, and compiling them takes longer than compiling the
kernel itself.

On a CPU, Warp runs a launch as one loop over all elements. Several threads can share a launch only if the loop can run
over a part of the elements. This module therefore changes one line of the C++ text from which Warp makes the loop: a
launch runs the last ``size`` elements of its ``shape``. In an ordinary launch these are all elements, so that no other
user of Warp notices the change. A launch of the elements from a to b has the shape b and the size b - a. The code for a
GPU does not change.
"""

from __future__ import annotations

import functools

import warp as wp
from warp._src import codegen

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

kernel = functools.partial(
    wp.kernel, module="unique", enable_backward=False, module_options={"cpu_compiler_flags": _FLAGS + _MARK}
)
"""Decorator of a kernel; it replaces ``wp.kernel``."""
