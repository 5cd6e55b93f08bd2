# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The decorator of kernels: each kernel is a module of its own, without derivatives.

A kernel in a module of its own is compiled again only if the kernel itself changes. By default Warp also compiles the
derivative of each kernel; StitchMesh does not use derivatives, and their compilation takes longer than that of the
kernel.
"""

from __future__ import annotations

import functools

import warp as wp

kernel = functools.partial(wp.kernel, module="unique", enable_backward=False)
"""Decorator of a kernel; it replaces ``wp.kernel``."""
