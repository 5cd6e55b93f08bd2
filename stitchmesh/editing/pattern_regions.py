# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Several patterns on one fabric, each on a selection of its faces.

All selections refer to the fabric without patterns, so that a pattern does not move the place of the next one. No face
may belong to two of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stitchmesh.editing.on_selection import places_after
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.mesh.renumbering import REMOVED
from stitchmesh.patterns import LaidPattern, Pattern, lay_pattern
from stitchmesh.patterns.placement.columns import DEFAULT_REMAINDER, Remainder
from stitchmesh.selection import Selection, select


@dataclass(frozen=True)
class PatternRegion:
    """A pattern on a part of a fabric."""

    pattern: Pattern
    """The pattern."""
    on: Selection | None = None
    """The part; None for the whole fabric."""
    remainder: Remainder = DEFAULT_REMAINDER
    """What happens to the stitches beside whole tiles of the pattern, as in ``apply_pattern``."""
    ground: str | None = None
    """Colour of the stitches left over, as in ``apply_pattern``."""
    centre: bool = False
    """Whether the middle of a tile lies in the middle of the front, as in ``apply_pattern``."""

    def __str__(self) -> str:
        return self.pattern.name if self.on is None else f"{self.pattern.name} on '{self.on}'"


def lay_patterns(fabric: StitchMesh, regions: Sequence[PatternRegion]) -> list[LaidPattern]:
    """Lay patterns on a fabric one after another; the last of the fabrics has all patterns.

    Args:
        fabric: a mesh of stitches.
        regions: the patterns and their parts of the fabric.

    Raises:
        ParameterError: a selection is empty, or a face belongs to two of them.
        StitchMeshError: an error of ``lay_pattern``; the message names the pattern and its selection.
    """
    chosen = [None if region.on is None else select(fabric, region.on) for region in regions]
    _check_apart(fabric.face_count, regions, chosen)
    done: list[LaidPattern] = []
    for number, region in enumerate(regions):
        try:
            laid = lay_pattern(
                fabric, region.pattern, faces=chosen[number], remainder=region.remainder, ground=region.ground,
                centre=region.centre,
            )  # fmt: skip
        except StitchMeshError as error:
            raise error if region.on is None else type(error)(f"on '{region.on}': {error}") from error
        for later in range(number + 1, len(regions)):
            faces = chosen[later]
            chosen[later] = None if faces is None else _kept(faces, fabric, laid)
        fabric = laid.fabric
        done.append(laid)
    return done


def _kept(faces: IntArray, before: StitchMesh, laid: LaidPattern) -> IntArray:
    """Return the numbers of faces outside a pattern after it was laid; the pattern may renumber them."""
    after = places_after(faces, before.face_count, laid.changes)
    return after[after != REMOVED]


def _check_apart(face_count: int, regions: Sequence[PatternRegion], chosen: Sequence[IntArray | None]) -> None:
    owner = np.full(face_count, -1)
    for number, faces in enumerate(chosen):
        inside = np.arange(face_count) if faces is None else faces
        taken = inside[owner[inside] >= 0]
        if len(taken):
            other = regions[owner[taken[0]]]
            both = f"{other} and {regions[number]} both cover {len(taken)} faces, such as face {taken[0]}"
            apart = "exclude one from the other" if other.on is None else f'add "and not ({other.on})" to the second'
            raise ParameterError(f"patterns: {both}; {apart}")
        owner[inside] = number
