# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What nodes of the layout remember while they are not simulated.

Eulerian coordinates of yarns that slid, rest angles of bends that yielded and anchors of friction are the marks of a
run. A node that a region drops keeps its marks in a memory, and has them again where the region grows back over it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mixed.enrichment.region import Region

Numbers = NDArray[np.float64]
SLIDING = "sliding"
"""Name of the Eulerian coordinates."""
PREFIX = "node memory "
"""How the names of the arrays of a checkpoint begin."""


@dataclass(frozen=True, eq=False)
class NodeMemory:
    """Values of all N nodes of the layout, by name."""

    values: Mapping[str, Numbers] = field(default_factory=dict)
    """Arrays of shape (N, ...), not a number where a node has never been simulated."""

    def kept(self, name: str, region: Region, values: NDArray[Any]) -> NodeMemory:
        """Return the memory with the present values of the simulated nodes of a region, shape (n, ...)."""
        missing = np.full((len(region.node_triangle), *values.shape[1:]), np.nan)
        everywhere = np.array(self.values.get(name, missing))
        everywhere[region.nodes] = values
        return NodeMemory({**self.values, name: everywhere})

    def recalled(self, name: str, at_rest: NDArray[Any]) -> Numbers:
        """Return the values of all nodes, those at rest for nodes that have never been simulated, shape (N, ...)."""
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
