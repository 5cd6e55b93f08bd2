# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the layers of a weave are stitched together."""

from __future__ import annotations

import numpy as np

from stitchmesh.periodic.weave.weave import Weave


def stitching(weave: Weave) -> list[list[int]]:
    """Weft and warp of each crossing at which a yarn passes over a yarn of a layer in front."""
    weft, warp = (np.array([thread.layer for thread in threads]) for threads in (weave.wefts, weave.warps))
    behind = weft[:, None] - warp[None, :]
    return np.argwhere(np.where(weave.over, behind > 0, behind < 0)).tolist()
