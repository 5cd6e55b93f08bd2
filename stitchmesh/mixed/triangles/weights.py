# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What users give for each triangle or panel when an energy is made: blending weights and materials."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial


def checked_weights(weight: ArrayLike | None, count: int) -> NDArray[np.float64]:
    """The blending weight 1 - alpha of each triangle or rod (C 4.1), shape (count,); 1 where none is given.

    Raises:
        ParameterError: the shape is not (count,), or a weight is not in [0, 1].
    """
    if weight is None:
        return np.ones(count)
    weights = np.asarray(weight, dtype=np.float64)
    if weights.shape != (count,):
        raise ParameterError(f"blending weights: got shape {weights.shape}; expected ({count},)")
    bad = np.flatnonzero(~((weights >= 0.0) & (weights <= 1.0)))
    if len(bad):
        raise ParameterError(f"blending weights: element {bad[0]} has {weights[bad[0]]:g}; expected 0 to 1")
    return weights


def materials_of_panels(materials: ClothMaterial | Sequence[ClothMaterial], panels: int) -> list[ClothMaterial]:
    """The material of each panel; one material alone is that of all panels.

    Raises:
        ParameterError: the number of materials is not that of the panels.
    """
    chosen = [materials] if isinstance(materials, ClothMaterial) else list(materials)
    if len(chosen) not in (1, panels):
        raise ParameterError(f"materials: got {len(chosen)}; expected one for all panels or one for each of {panels}")
    return chosen
