# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Copies of some elements of an array."""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel


@kernel
def copy_where(
    # state in
    chosen: wp.array[wp.int32],
    source: wp.array[Any],
    # state out
    target: wp.array[Any],
) -> None:
    """Copy the chosen elements."""
    i = wp.tid()
    if chosen[i] != 0:
        target[i] = source[i]
