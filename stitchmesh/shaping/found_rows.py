# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The search for rows and stitches on any mesh or on the panels of a sewing pattern, and the figures of its report."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.repair import self_intersections
from stitchmesh.progress import Progress
from stitchmesh.shaping.auto_stitches import EDGE_OVER_WIDTH, shape_fabric
from stitchmesh.shaping.found_stitches import FoundStitches
from stitchmesh.shaping.options import ShapingOptions
from stitchmesh.shaping.panels.options import PanelOptions
from stitchmesh.shaping.panels.panel_mesh import PanelMesh
from stitchmesh.shaping.panels.shape_panels import knit_panels
from stitchmesh.shaping.report import shaping_report
from stitchmesh.shaping.triangle_surface import TriangleSurface, triangle_surface

logger = logging.getLogger(__name__)

AFTER_MESH_RELAXATION = ("rms_distance", "largest_distance", "rms_stretch", "rms_edge_stretch")
"""Figures that are measured again after mesh relaxation."""
OF_WHOLE_MESHES = ("lost",)
"""Figures that panels do not have: a seam that is left to be sewn is a border, but no loss."""
MOST_CROSSINGS = 100
"""The search for faces of a given mesh that cross each other ends after this number of pairs."""
Entry = dict[str, Any]
"""The figures of a report on stitches, by name."""


def found_on_mesh(
    mesh: Mesh, options: ShapingOptions, *, stitch_width: float, stitch_height: float | None, progress: Progress
) -> tuple[FoundStitches, Entry]:
    """Find rows and stitches on a mesh of any kind, and warn of lost features and of faces that cross each other.

    Raises:
        StitchMeshError: as for ``shape_fabric``.
    """
    shaped = shape_fabric(
        mesh, stitch_width=stitch_width, stitch_height=stitch_height, options=options, progress=progress
    )
    if shaped.report.lost:
        logger.warning(shaped.report.lost)
    entry = {**asdict(shaped.report), "crossing_faces": _crossing_faces(mesh)}
    return FoundStitches(shaped.fabric, shaped.given, None if shaped.flat else shaped.surface), entry


def found_on_panels(
    panels: PanelMesh, options: PanelOptions, *, stitch_width: float, stitch_height: float | None, progress: Progress
) -> tuple[FoundStitches, Entry]:
    """Knit the panels of a sewing pattern, and join them.

    Raises:
        StitchMeshError: as for ``knit_panels``.
    """
    shaped = knit_panels(
        panels, stitch_width=stitch_width, stitch_height=stitch_height,
        directions={one.panel: one.direction for one in options.directions}, sewn=options.sewn,
        shaping=options.shaping, progress=progress,
    )  # fmt: skip
    given = triangle_surface(panels.mesh, EDGE_OVER_WIDTH * stitch_width)
    fit = asdict(shaping_report(shaped.fabric, given, stitch_width, shaped.report.seconds))
    entry = {
        **{name: value for name, value in fit.items() if name not in OF_WHOLE_MESHES}, **asdict(shaped.report),
        "panels": panels.panel_count,
        "stitches_of_panels": np.bincount(shaped.face_panel, minlength=panels.panel_count).tolist(),
        "seams": [
            {"panels": list(seam.panels), "kind": seam.kind, "length_cm": round(seam.length, 3), "edges": seam.edges}
            for seam in shaped.seams
        ],
    }  # fmt: skip
    return FoundStitches(shaped.fabric, given, None), entry


def after_mesh_relaxation(fabric: StitchMesh, surface: TriangleSurface, stitch_width: float, entry: Entry) -> Entry:
    """Return the entry with the distances from the given surface and the stretch of the relaxed stitches.

    The counts still refer to the stitches that were found, before patterns and edits.
    """
    relaxed = asdict(shaping_report(fabric, surface, stitch_width, 0.0))
    return {**entry, **{name: relaxed[name] for name in AFTER_MESH_RELAXATION}}


def panel_of_face(face: int, fabric: StitchMesh, entry: Mapping[str, Any]) -> int | None:
    """Return the panel of a stitch; None where there are no panels, or edits have changed the number of stitches.

    Stitches lie in the order of their panels.
    """
    ends = np.cumsum(entry.get("stitches_of_panels", []))
    if not len(ends) or int(ends[-1]) != fabric.face_count:
        return None
    return int(np.searchsorted(ends, face, side="right"))


def _crossing_faces(mesh: Mesh) -> list[list[int]]:
    """Return pairs of faces that cross each other, and warn of them: the fabric passes through itself there."""
    pairs: list[list[int]] = self_intersections(mesh, MOST_CROSSINGS).tolist()
    if pairs:
        count = f"{MOST_CROSSINGS} or more pairs" if len(pairs) == MOST_CROSSINGS else f"{len(pairs)} pair(s)"
        logger.warning(
            f"the mesh crosses itself: {count} of faces, such as {pairs[0][0]} and {pairs[0][1]}; yarns may start too "
            "close there: move the parts of the mesh apart"
        )
    return pairs
