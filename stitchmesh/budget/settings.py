# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The settings between which a budget chooses: qualities with their solvers, and the stopping rule for an error."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from stitchmesh.quality import PRESETS, Quality

SETTINGS: Mapping[str, Quality] = PRESETS | {"standard by dynamics": replace(PRESETS["standard"], solver="dynamics")}
"""The settings by name."""
LEFT = 0.5
"""Part of an error that may be left when a relaxation stops; the other part is for the sampling."""
SMALLEST_CHANGE = {"float32": 1e-4, "float64": 1e-6}
"""Smallest estimate of the change that is left which each precision resolves."""
MORE_ITERATIONS = 50
"""Factor of the limit of iterations where a budget ends the relaxation instead."""


def tightened(quality: Quality, error: float | None) -> Quality:
    """Return a quality that stops no earlier than an error allows, and is not ended by its limit of iterations.

    Args:
        quality: the quality of a setting.
        error: largest relative error of the spacing; None keeps the rule of the quality.
    """
    limit = MORE_ITERATIONS * quality.max_iterations
    if error is None:
        return replace(quality, max_iterations=limit)
    change = max(LEFT * error, SMALLEST_CHANGE[quality.precision])
    return replace(quality, max_iterations=limit, largest_change=min(quality.largest_change, change))
