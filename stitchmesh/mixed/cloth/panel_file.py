# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Panels and seams as files: TOML with the fields of ``PanelFile`` as keys.

    edge_length = 1.0                                       # of the triangles [cm]

    [[panels]]
    name = "front"
    outline = [[0, 0], [50, 0], [50, 60], [0, 60]]          # corners [cm], anticlockwise
    position = { origin = [0, 0, 10] }                      # also x_axis, y_axis, radius

    [[seams]]
    first = { panel = "front", start = 1, end = 2 }         # from corner to corner, anticlockwise
    second = { panel = "back", start = 3, end = 0 }
    angle = 0                                               # at rest [degrees]

Corners are counted from 0. ``PanelFile``, ``Panel``, ``PanelPosition`` and ``PanelSeam`` define the other keys and
their defaults.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from stitchmesh.io.contents import FilePath
from stitchmesh.io.toml_file import read_dataclass
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.cloth.panels import Panel, checked_edge_length
from stitchmesh.mixed.cloth.seams import PanelSeam, cloth_from_panels, seam_counts
from stitchmesh.mixed.cloth.starting_shape import checked_rounds, evened_vertices


@dataclass(frozen=True, kw_only=True)
class PanelFile:
    """The content of a file of panels and seams.

    Raises:
        ParameterError: as ``seam_counts`` raises it.
    """

    edge_length: float
    """Wanted length of the triangle edges [cm]."""
    panels: tuple[Panel, ...]
    """The panels."""
    seams: tuple[PanelSeam, ...] = ()
    """The seams."""
    evening_rounds: int = 0
    """Rounds in which the strain of the starting shape is spread over the panels (``evened_vertices``)."""

    def __post_init__(self) -> None:
        checked_edge_length(self.edge_length)
        checked_rounds(self.evening_rounds)
        seam_counts(self.panels, self.seams, self.edge_length)

    def cloth(self) -> Cloth:
        """Return the panels divided into triangles, sewn together, and evened out.

        Raises:
            ParameterError: a panel cannot be divided.
            MeshError: the panels sewn together are not a manifold surface.
        """
        sewn = cloth_from_panels(self.panels, self.seams, edge_length=self.edge_length)
        return replace(sewn, vertices=evened_vertices(sewn, rounds=self.evening_rounds))


def read_panels(path: FilePath) -> PanelFile:
    """Read panels and seams from a TOML file.

    Raises:
        FileError: the file cannot be read, is not TOML, has a key or a value that it cannot have, or describes panels
            that cannot be sewn; the message names the key and, for an unknown key, the nearest known one.
    """
    return read_dataclass(path, PanelFile)
