# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What static scenes cost whose yarns begin on the layout, and on the result of the triangles.

    python benchmarks/mixed_starts.py examples/mixed/ball.toml examples/mixed/puckering.toml
    python benchmarks/mixed_starts.py examples/mixed/corner.toml --held --regions chosen all
    python benchmarks/mixed_starts.py examples/mixed/ball.toml --nodes 269

Prints the products of the linear solves and the energy at the end [erg] of both starts; the products of the triangles
stand in brackets. With ``--held`` nothing that is attached is released.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

from stitchmesh.mixed.drape import drape
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import Scene
from stitchmesh.mixed.scene.scene_file import read_scene

STARTS = ("layout", "triangles")
"""Where yarns may begin."""


def main() -> None:
    """Run each scene from both starts and print a row."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", type=Path, nargs="+")
    parser.add_argument("--regions", nargs="+", default=["chosen"], choices=["chosen", "all"])
    parser.add_argument("--nodes", type=int, help="an automatic region of so many yarn nodes")
    parser.add_argument("--held", action="store_true", help="release no attachment")
    given = parser.parse_args()
    print("| scene | yarns | products from the layout | from the triangles | energies [erg] |\n|---|---|---|---|---|")
    for path in given.scenes:
        scene = read_scene(path)
        if given.held:
            scene = replace(scene, attachments=tuple(replace(each, release=None) for each in scene.attachments))
        if given.nodes is not None:
            scene = replace(scene, region=RegionSection(yarns="automatic", nodes=given.nodes))
        for region in given.regions if given.nodes is None else ["automatic"]:
            found = [report_of(scene, region, start) for start in STARTS]
            products = [words(each) for each in found]
            energies = ", ".join(f"{each['energy']:.6g}" for each in found)
            print(f"| {path.name} | {region} | {products[0]} | {products[1]} | {energies} |", flush=True)


def report_of(scene: Scene, region: str, start: str) -> dict[str, Any]:
    """Run a scene and return its report."""
    chosen: dict[str, Any] = {"yarns": region, "start": start}
    report: dict[str, Any] = drape(replace(scene, region=replace(scene.region, **chosen))).report["mixed"]
    return report


def words(report: dict[str, Any]) -> str:
    """Return the products of a run, with those of its triangles in brackets, and whether it converged."""
    triangles = f" (+ {report['triangle_run']['solve_iterations']:,})" if "triangle_run" in report else ""
    return f"{report['solve_iterations']:,}{triangles}" + ("" if report["converged"] else ", not converged")


if __name__ == "__main__":
    main()
