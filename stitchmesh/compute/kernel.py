# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Declaration of kernels: each kernel is compiled separately and without its derivative.

A kernel in its own Warp module is compiled again only if it changes. By default, Warp also compiles the derivative of
each kernel. Nothing in StitchMesh uses derivatives, and their compilation takes longer than that of the kernels.
"""

from __future__ import annotations

import functools

import warp as wp

kernel = functools.partial(wp.kernel, module="unique", enable_backward=False)
"""Decorator of a kernel, in place of ``wp.kernel``."""
