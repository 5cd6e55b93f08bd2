# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The memory of terms when the region of a run changes.

Rest angles of bending and anchors of friction between yarns belong to nodes; anchors on bodies belong to contact
points. Nodes and points that stay keep their values. A new node gets the values that it had when it was simulated last,
or begins as laid out. A new contact point finds its anchor at its present place.

Nodes of the layout keep values also while they are not simulated. Eulerian coordinates of yarns that slid, rest angles
of bends that yielded and anchors of friction are the marks of a run. A node that leaves the region keeps its marks in a
memory, and gets them back where the region grows over it again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import IntArray
from stitchmesh.mixed.contact.body_friction import BodyFriction
from stitchmesh.mixed.contact.contact_points import ContactPoints
from stitchmesh.mixed.enrichment.region import Region
from stitchmesh.mixed.term import MixedTerm

Numbers = NDArray[np.float64]
SLIDING = "sliding"
"""Name of the Eulerian coordinates."""
PREFIX = "node memory "
"""How the names of the arrays of a checkpoint begin."""


@dataclass(frozen=True, eq=False)
class NodeMemory:
    """Values of all N nodes of the layout, by name."""

    values: Mapping[str, Numbers] = field(default_factory=dict)
    """Arrays of shape (N, ...); their values are not numbers where a node has never been simulated."""

    def kept(self, name: str, region: Region, values: NDArray[Any]) -> NodeMemory:
        """Return the memory with the present values of the simulated nodes of a region, shape (n, ...)."""
        missing = np.full((len(region.node_triangle), *values.shape[1:]), np.nan)
        everywhere = np.array(self.values.get(name, missing))
        everywhere[region.nodes] = values
        return NodeMemory({**self.values, name: everywhere})

    def recalled(self, name: str, at_rest: NDArray[Any]) -> Numbers:
        """Return the values of all nodes, shape (N, ...); nodes that were never simulated have their values at rest."""
        known = self.values.get(name)
        result: Numbers = np.array(at_rest) if known is None else np.where(np.isnan(known), at_rest, known)
        return result

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of a checkpoint."""
        return {f"{PREFIX}{name}": values for name, values in self.values.items()}

    @staticmethod
    def of(arrays: Mapping[str, NDArray[Any]]) -> NodeMemory:
        """Return the memory of a checkpoint."""
        return NodeMemory({name[len(PREFIX) :]: np.asarray(a) for name, a in arrays.items() if name.startswith(PREFIX)})


@dataclass(frozen=True, eq=False)
class RegionChange:
    """The region of a run before and after a change, with its contact points."""

    old: Region
    new: Region
    memory: NodeMemory
    """The memory of nodes, with the last values of the old region (``remember``)."""
    old_points: ContactPoints | None = None
    """Contact points of the old region; none without contact."""
    new_points: ContactPoints | None = None


def remember(memory: NodeMemory, terms: Sequence[MixedTerm], region: Region) -> NodeMemory:
    """Return a memory that includes the values of the terms of a region at its nodes.

    Raises:
        ParameterError: a term has values that belong neither to nodes nor to contact points.
    """
    for key, term in _keyed(terms):
        for name, array in () if isinstance(term, BodyFriction) else term.carried_arrays().items():
            values = array.numpy()
            if len(values) != len(region.nodes):
                found = f"{term.name}: remembers {len(values)} values"
                raise ParameterError(f"{found}; expected one for each of {len(region.nodes)} nodes: keep the region")
            memory = memory.kept(_named(key, name), region, values)
    return memory


def _named(key: tuple[str, int], name: str) -> str:
    """Name of an array of a term in the memory."""
    return f"{key[0]} {key[1]} {name}"


def carry_terms(old: Sequence[MixedTerm], new: Sequence[MixedTerm], change: RegionChange) -> None:
    """Give to the terms of a new region the remembered values of the terms of the old region.

    Args:
        old: the terms of the old region.
        new: the terms of the new region, as they begin; changed.
        change: both regions, and the memory of nodes.
    """
    remembered = dict(_keyed(old))
    for key, term in _keyed(new):
        own = {name: array.numpy() for name, array in term.carried_arrays().items()}
        if isinstance(term, BodyFriction):
            before = remembered[key].carried_arrays() if key in remembered else {}
            own = {name: _at_points(before[name].numpy(), array, change) for name, array in own.items() if before}
        else:
            own = {name: _at_nodes(_named(key, name), array, change) for name, array in own.items()}
        if own:
            term.carry(own)


def _keyed(terms: Sequence[MixedTerm]) -> list[tuple[tuple[str, int], MixedTerm]]:
    """Each term with its name, and its number among the terms of this name."""
    names = [term.name for term in terms]
    return [((term.name, names[:place].count(term.name)), term) for place, term in enumerate(terms)]


def _at_nodes(name: str, start: NDArray[Any], change: RegionChange) -> NDArray[Any]:
    """One array of a term of the new region: the remembered values of its nodes, or their values at the start."""
    at_rest = np.zeros((len(change.new.node_triangle), *start.shape[1:]))
    at_rest[change.new.nodes] = start
    return change.memory.recalled(name, at_rest)[change.new.nodes]


def _at_points(before: NDArray[Any], start: NDArray[Any], change: RegionChange) -> NDArray[Any]:
    """One array of the friction on bodies: the old values at points that stay, the values at the start elsewhere."""
    result = np.array(start)
    if change.old_points is not None and change.new_points is not None:
        there, here = _same_points(change)
        result[here] = before[there]
    return result


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
    """A key for each contact point that is the same in all regions: its vertices or its layout node, and its shares."""
    numbered = np.concatenate([np.arange(points.vertex_count), points.vertex_count + region.nodes])
    shares = np.rint(points.share * 2**20).astype(np.int64)  # all shares are multiples of a power of 1/2
    rows = np.concatenate([numbered[points.index], shares], axis=1)
    return [row.tobytes() for row in np.ascontiguousarray(rows)]
