# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Model the garments of StitchMesh, and write them as OBJ files into the folder of this script.

Usage: python assets/meshes/model_garments.py [--out FOLDER]

The meshes are coarse and consist of quads only; coordinates are in centimetres with y upwards. The
meshes are checked before they are written, and a table of their faces, rows and borders is printed.
The result is deterministic.
"""

import argparse
from collections.abc import Callable
from pathlib import Path

from knit_check import Report, check_garment
from model_alien import model_alien
from model_dress import model_dress
from model_glove import model_glove
from model_round import model_hat, model_poncho, model_sock, model_swatch, model_tea_cozy
from model_sheep import model_sheep
from model_sweater import model_sweater
from quad_mesh import Garment

MODELS: tuple[Callable[[], Garment], ...] = (
    model_sweater,
    model_dress,
    model_glove,
    model_tea_cozy,
    model_poncho,
    model_hat,
    model_sock,
    model_alien,
    model_sheep,
    model_swatch,
)


def describe(name: str, report: Report) -> str:
    """Return the lines of the printed table for one garment."""
    lines = [
        f"{name}: {report.faces} faces, {report.vertices} vertices, {report.rows} rows, "
        f"{report.columns} columns, edges {report.shortest_edge:.1f}-{report.longest_edge:.1f} cm"
    ]
    for border in report.borders:
        count = len(border.loop)
        kinds = f"{border.course_edges} course, {count - border.course_edges} wale"
        lines.append(f"  {border.name}: {count} edges ({kinds}), {border.length:.1f} cm")
    return "\n".join(lines)


def main() -> None:
    """Model, check and write all garments."""
    parser = argparse.ArgumentParser(description="Model the garments of StitchMesh.")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent, help="output folder")
    out: Path = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    for model in MODELS:
        garment = model()
        try:
            report = check_garment(garment)
        except ValueError as error:
            raise ValueError(f"{garment.name}: {error}") from error
        garment.mesh.write_obj(out / f"{garment.name}.obj", f"StitchMesh {garment.name}")
        print(describe(garment.name, report))


if __name__ == "__main__":
    main()
