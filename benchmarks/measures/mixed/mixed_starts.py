# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What static scenes cost whose yarns begin on the layout, and on the result of the triangles.

Prints the products of the linear solves and the energy at the end [erg] of both starts; the products of the triangles
stand in brackets. With ``--held`` nothing that is attached is released.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

from benchmarks.table import Rows
from stitchmesh.mixed.drape import drape
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import Scene
from stitchmesh.mixed.scene.scene_file import read_scene

STARTS = ("layout", "triangles")
"""Where yarns may begin."""


def mixed_starts(
    scenes: tuple[Path, ...],
    /,
    *,
    regions: tuple[Literal["chosen", "all"], ...] = ("chosen",),
    nodes: int | None = None,
    held: bool = False,
) -> Rows:
    """Run each scene from both starts and print a row.

    Args:
        nodes: an automatic region of so many yarn nodes
        held: release no attachment
    """
    yield "scene", "yarns", "products from the layout", "from the triangles", "energies [erg]"
    for path in scenes:
        scene = read_scene(path)
        if held:
            scene = replace(scene, attachments=tuple(replace(each, release=None) for each in scene.attachments))
        if nodes is not None:
            scene = replace(scene, region=RegionSection(yarns="automatic", nodes=nodes))
        for region in regions if nodes is None else ["automatic"]:
            found = [report_of(scene, region, start) for start in STARTS]
            products = [words(each) for each in found]
            energies = ", ".join(f"{each['energy']:.6g}" for each in found)
            yield path.name, region, products[0], products[1], energies


def report_of(scene: Scene, region: str, start: str) -> dict[str, Any]:
    """Run a scene and return its report."""
    chosen: dict[str, Any] = {"yarns": region, "start": start}
    report: dict[str, Any] = drape(replace(scene, region=replace(scene.region, **chosen))).report["mixed"]
    return report


def words(report: dict[str, Any]) -> str:
    """Return the products of a run, with those of its triangles in brackets, and whether it converged."""
    triangles = f" (+ {report['triangle_run']['solve_iterations']:,})" if "triangle_run" in report else ""
    return f"{report['solve_iterations']:,}{triangles}" + ("" if report["converged"] else ", not converged")
