# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a table lets one expect of a setting on a scene: time and error.

A scene that the table has by name is expected to cost what it cost. Any other scene is compared with the measured ones
of its kind that are nearest to its size, whose times are scaled by the numbers of stitches; the time that is expected
is the median of these, and the time that is allowed for is the largest. The error is the largest one of the kind,
because the error of an unknown pattern does not follow from its size. A setting that came to rest in few of the scenes
(``IN_MOST``) is left out: its rows would be those of the easy scenes.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

from stitchmesh.budget.tables import Kind, MeasuredRelaxation, Table

NEAREST = 8
"""Measured scenes with which a new one is compared."""
IN_MOST = 0.75
"""Part of the scenes in which a setting has to be at rest with a known error."""


@dataclass(frozen=True, kw_only=True)
class BudgetScene:
    """What is to be relaxed."""

    kind: Kind
    """Kind of the scene."""
    stitches: int
    """Number of stitches, or of crossings of a weave."""
    name: str = ""
    """Name of the pattern or of the mesh, if there is one."""
    relaxations: int = 1
    """Number of relaxations, one after another."""


@dataclass(frozen=True, kw_only=True)
class Expectation:
    """Time and error of a setting on a scene."""

    setting: str
    """Name of the setting."""
    seconds: float
    """Time that is expected [s]."""
    most_seconds: float
    """Time that is allowed for [s]."""
    error: float
    """Relative error of the spacing."""


def expectations(table: Table, scene: BudgetScene, slowness: float = 1.0) -> list[Expectation]:
    """Return what a table lets one expect of each setting that came to rest in it, the cheapest first.

    Args:
        table: the table.
        scene: the scene.
        slowness: time of this device over that of the table.
    """
    rows = [row for row in table.of(scene.kind) if row.converged]
    rows = [row for row in rows if row.scene == scene.name and row.error is not None] or rows
    needed = IN_MOST * len({row.scene for row in rows if row.error is not None})
    found = []
    for name in dict.fromkeys(row.setting for row in rows):
        own = [row for row in rows if row.setting == name]
        if sum(row.error is not None for row in own) >= max(needed, 1):
            found.append(_expectation(name, own, scene, slowness))
    return sorted(found, key=lambda one: one.most_seconds)


def _expectation(setting: str, rows: Sequence[MeasuredRelaxation], scene: BudgetScene, slowness: float) -> Expectation:
    errors = [row.error for row in rows if row.error is not None]
    near = sorted(rows, key=lambda row: abs(math.log(row.stitches / scene.stitches)))[:NEAREST]
    slowness *= scene.relaxations
    seconds = [slowness * row.seconds * scene.stitches / row.stitches for row in near]
    middle, most = statistics.median(seconds), max(seconds)
    return Expectation(setting=setting, seconds=middle, most_seconds=most, error=max(errors))
