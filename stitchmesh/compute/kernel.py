# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How kernels are declared: each compiled by itself, forwards only.

A kernel by itself is compiled again only where it changes. Warp would compile the derivative of each too, which nothing
here asks for and which takes longer than the kernel.
"""

from __future__ import annotations

import functools

import warp as wp

kernel = functools.partial(wp.kernel, module="unique", enable_backward=False)
"""Decorator of a kernel, in place of ``wp.kernel``."""
