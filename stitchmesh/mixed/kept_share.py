# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The part of the exact Hessian in the products of a term, kept on the device as a launch that can be captured."""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel


@kernel
def keep_share(
    # state in
    exact: Any,
    # state out
    share: wp.array[Any],
) -> None:
    """Keep the share of the exact Hessian."""
    share[wp.tid()] = exact
