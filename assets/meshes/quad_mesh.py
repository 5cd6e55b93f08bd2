# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A small quad mesh that is built ring by ring, as a garment is knitted."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

Quad = tuple[int, int, int, int]
Ring = list[int]

LICENCE_HEADER = (
    "# SPDX-FileCopyrightText: StitchMesh contributors",
    "# SPDX-License-Identifier: Apache-2.0",
)


@dataclass
class QuadMesh:
    """Points and quads; rows are added upwards, from left to right as seen from outside."""

    points: list[np.ndarray] = field(default_factory=list)
    quads: list[Quad] = field(default_factory=list)

    def add(self, points: np.ndarray | Sequence[Sequence[float]]) -> Ring:
        """Add points of shape (n, 3) and return their numbers."""
        first = len(self.points)
        self.points.extend(np.asarray(points, dtype=float))
        return list(range(first, len(self.points)))

    def bridge(self, lower: Ring, upper: Ring, closed: bool = True) -> None:
        """Add one row of quads between two rings, or two open lines, with equally many vertices."""
        if len(lower) != len(upper):
            raise ValueError(f"cannot bridge {len(lower)} and {len(upper)} vertices")
        count = len(lower)
        for i in range(count if closed else count - 1):
            j = (i + 1) % count
            self.quads.append((lower[i], lower[j], upper[j], upper[i]))

    def grow(self, start: Ring, rings: Sequence[np.ndarray], closed: bool = True) -> Ring:
        """Add rows of quads from `start` through new rings of points; return the last ring."""
        for points in rings:
            upper = self.add(points)
            self.bridge(start, upper, closed)
            start = upper
        return start

    def write_obj(self, path: Path, title: str) -> None:
        """Write a Wavefront OBJ file (1-based indices, centimetres)."""
        lines = [*LICENCE_HEADER, f"# {title}; unit: cm; y is up"]
        lines += ["v " + " ".join(f"{x + 0.0:.4f}" for x in np.round(p, 4)) for p in self.points]
        lines += ["f " + " ".join(str(i + 1) for i in quad) for quad in self.quads]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")


@dataclass
class Garment:
    """A named mesh with named borders."""

    name: str
    mesh: QuadMesh
    borders: dict[str, int]
    """One vertex of each border, by the name of the border."""
    first_course: list[tuple[int, int]] | None = None
    """Edges that are known to be course edges; by default the edges of the longest border."""
