# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What terms remember, after the region of a run has changed.

Rest angles of bending and anchors of friction between yarns belong to nodes, anchors on bodies to contact points. Nodes
and points that stay keep theirs. New nodes begin as they are laid out, and new contact points find their anchors where
they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import IntArray
from stitchmesh.mixed.contact.body_friction import BodyFriction
from stitchmesh.mixed.contact.contact_points import ContactPoints
from stitchmesh.mixed.enrichment.region import Region
from stitchmesh.mixed.placement.moved_state import moved_values
from stitchmesh.mixed.term import Term

PARTS = 1 << 20
"""Shares of contact points are compared as multiples of one over this number; they are multiples of a power of 1/2."""


@dataclass(frozen=True, eq=False)
class RegionChange:
    """The region of a run before and after a change, with its contact points."""

    old: Region
    new: Region
    old_points: ContactPoints | None = None
    """Contact points of the old region; none without contact."""
    new_points: ContactPoints | None = None


def carry_terms(old: Sequence[Term], new: Sequence[Term], change: RegionChange) -> None:
    """Give terms of a new region what those of the old one remember.

    Args:
        old: the terms of the old region.
        new: the terms of the new one, as they begin; changed.
        change: both regions.

    Raises:
        ParameterError: a term remembers what belongs neither to nodes nor to contact points.
    """
    remembered = {key: term.carried_arrays() for key, term in _keyed(old)}
    for key, term in _keyed(new):
        own = {name: array.numpy() for name, array in term.carried_arrays().items()}
        before = {name: array.numpy() for name, array in remembered.get(key, {}).items()}
        if own and before:
            term.carry({name: _carried(term, before[name], array, change) for name, array in own.items()})


def _keyed(terms: Sequence[Term]) -> list[tuple[tuple[str, int], Term]]:
    """Each term with its name, and its number among the terms of this name."""
    names = [term.name for term in terms]
    return [((term.name, names[:place].count(term.name)), term) for place, term in enumerate(terms)]


def _carried(term: Term, before: NDArray[Any], start: NDArray[Any], change: RegionChange) -> NDArray[Any]:
    """One array of a term: the old values where nodes or points stay, those of the start elsewhere."""
    if isinstance(term, BodyFriction) and change.old_points is not None and change.new_points is not None:
        there, here = _same_points(change)
        result = np.array(start)
        result[here] = before[there]
        return result
    if len(before) != len(change.old.nodes) or len(start) != len(change.new.nodes):
        found = f"{term.name}: remembers {len(before)} values"
        raise ParameterError(f"{found}; expected one for each of {len(change.old.nodes)} nodes: keep the region")
    at_rest = np.zeros((len(change.new.node_triangle), *start.shape[1:]))
    at_rest[change.new.nodes] = start
    return moved_values(change.old, change.new, before, at_rest)


def _same_points(change: RegionChange) -> tuple[IntArray, IntArray]:
    """Numbers in the old and in the new region of the contact points that both have."""
    assert change.old_points is not None
    assert change.new_points is not None
    number = {key: place for place, key in enumerate(_point_keys(change.old_points, change.old))}
    pairs = [(number.get(key, -1), place) for place, key in enumerate(_point_keys(change.new_points, change.new))]
    there, here = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    kept = there >= 0
    return there[kept], here[kept]


def _point_keys(points: ContactPoints, region: Region) -> list[bytes]:
    """What identifies each contact point in all regions: its vertices or its node of the layout, and its shares."""
    numbered = np.concatenate([np.arange(points.vertex_count), points.vertex_count + region.nodes])
    shares = np.rint(points.share * PARTS).astype(np.int64)
    rows = np.concatenate([numbered[points.index], shares], axis=1)
    return [row.tobytes() for row in np.ascontiguousarray(rows)]
