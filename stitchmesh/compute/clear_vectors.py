# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Setting an array of vectors to zero among other launches of kernels."""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel


@kernel
def clear_vectors(
    # state out
    vectors: wp.array[Any],
) -> None:
    """Set an array to zero, in a launch like others."""
    i = wp.tid()
    vectors[i] = type(vectors[0])()
