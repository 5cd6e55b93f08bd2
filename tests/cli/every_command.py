# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Words with which each command does its work, on a folder with a small input of each kind."""

from __future__ import annotations

from pathlib import Path

import stitchmesh as sm
from stitchmesh.cli.main import main
from stitchmesh.quality import quality_named, quality_with
from tests.gallery import tube

WORDS: dict[str, list[list[str]]] = {
    "knit": [["tube.obj", "-o", "out", "--stitch-width", "8", "--no-picture"],
             ["tube.obj", "-o", "out", "--stitch-width", "8", "--no-picture", "--auto"]],
    "label": [["tube.obj", "-o", "out.h5"], ["tube.obj", "-o", "out.h5", "--auto"]],
    "tessellate": [["labeled.h5", "-o", "out.h5"]],
    "pattern": [["stitches.h5", "rib1x1", "-o", "out.h5"]],
    "capture": [["stitches.h5", "-o", "out.knit", "--on", "row 2"]],
    "edit": [["stitches.h5", "side=61", "courses=2", "--apply", "insert_wale", "-o", "out.h5"]],
    "relax-mesh": [["stitches.h5", "--surface", "labeled.h5", "-o", "out.h5"]],
    "yarns": [["stitches.h5", "-o", "out.h5"]],
    "relax": [["yarns.h5", "-o", "out.h5"]],
    "relax-edited": [["yarns.h5", "--before", "stitches.h5", "--after", "stitches.h5", "-o", "out.h5"]],
    "outline": [["rib1x1", "-o", "out", "--columns", "2", "--rows", "2"]],
    "swatch": [["stockinette", "-o", "out", "--no-picture"], ["plain", "-o", "out", "--no-picture"],
               ["stockinette", "-o", "out", "--no-picture", "--relaxation", "dry"]],
    "stretch": [["stockinette", "-o", "out", "--course", "0:4%", "--steps", "2"]],
    "squeeze": [["stockinette", "-o", "out", "--to", "0.9", "--steps", "1"]],
    "fit": [["--pattern", "stockinette", "-o", "out.toml", "--gauge", "20x26"]],
    "drape": [["scene.toml", "-o", "out", "--no-picture"]],
    "follow": [["rest.h5", "frames", "-o", "out"]],
    "animate": [["stitches.h5", "moving", "-o", "out"]],
    "run": [["job.toml", "-o", "out"]],
    "job": [["init", "tube.obj", "-o", "out.toml"]],
    "status": [["job"]],
    "batch": [["sweep.toml", "-o", "out", "--workers", "0"]],
    "book": [["stockinette", "-o", "out", "--no-stretch", "--relaxation", "frictionless", "--workers", "0"]],
    "info": [["yarns.h5"]], "check": [["yarns.h5"]], "select": [["stitches.h5", "row 1", "-o", "out.txt"]],
    "patterns": [[]], "examples": [[], ["-o", "out"]], "instructions": [["stitches.h5", "-o", "out.txt"]],
    "convert": [["cell.h5", "out.bcc"]],
    "render": [["yarns.h5", "-o", "out.png", "--size", "32", "32"], ["cell.h5", "-o", "out.png", "--size", "32", "32"]],
    "view": [["yarns.h5", "--no-browser"]], "app": [["tube.obj", "--project", "out", "--no-browser"]],
    "blender-addon": [["-o", "out.zip"]],
    "warm-up": [["--device", "cpu"]], "measure": [["stockinette", "-o", "out", "--quality", "draft"]],
    "yarn": [["list"], ["show", "dk"]],
    "grade": [["tube.toml", "--sizes", "sizes.csv", "-o", "out", "--no-picture"]],
}  # fmt: skip
"""The words after the name of each command; every output begins with ``out``."""
SCENE = """
mode = "dynamic"
duration = 0.004
largest_step = 0.004
[cloth]
rectangle = [3, 3]
edge_length = 1.0
[yarns]
weave = "plain"
ends = 5
picks = 5
material = "gong-1"
[region]
yarns = "chosen"
boxes = [{ low = [1, 1, -1], high = [2, 2, 1] }]
[[attachments]]
boxes = [{ low = [-1, 2.85, -1], high = [7, 7, 1] }]
"""
PINCHED = "v 0 0 0\nv 5 5 0\nv 5 0 0\nv 0 5 0\nv 2 2 5\nf 1 2 5\nf 3 4 5\nf 1 3 5\n"


def write_inputs(folder: Path) -> Path:
    """Write an input of each kind into a folder."""
    mesh = tube(8, 3, radius=20.0, height=12.0)
    labeled = sm.label(mesh)
    fabric = sm.tessellate(labeled, stitch_width=8.0)
    sm.write_mesh(folder / "tube.obj", mesh)
    (folder / "pinched.obj").write_text(PINCHED)
    sm.write_stitches(folder / "labeled.h5", labeled)
    sm.write_stitches(folder / "stitches.h5", fabric)
    yarns = sm.generate_yarns(fabric, quality="draft")
    for name in ("yarns.h5", "yarns.usda"):
        sm.write_yarns(folder / name, yarns)
    brief = quality_named(quality_with("draft", max_iterations=20))
    sm.write_yarns(folder / "rest.h5", sm.relax_yarns(yarns, quality="draft", device="cpu").yarns)
    sm.write_yarns(folder / "cell.h5", sm.swatch("stockinette", quality=brief, device="cpu").yarns)
    for frame in range(3):
        sm.write_mesh(folder / "frames" / f"b.{frame:04d}.obj", tube(8, 3, radius=10.0, height=12.0))
        sm.write_mesh(folder / "moving" / f"m.{frame:04d}.obj", mesh)
    (folder / "deep.jsonl").write_text('{"edit": "flip_row", "arguments": {"face": ' + "[" * 900 + "]" * 900 + "}}\n")
    head, swatch = 'quality = "draft"\ndevice = "cpu"\n', 'pattern = "stockinette"\nmax_iterations = 2\n'
    (folder / "job.toml").write_text(f"{head}render = []\n[swatch]\n{swatch}")
    (folder / "sweep.toml").write_text(
        f"picture = false\n[job]\n{head}[job.swatch]\n{swatch}[grid]\nswatch.gamma = [1.0]\n"
    )
    (folder / "scene.toml").write_text(SCENE)
    (folder / "tube.toml").write_text(f'mesh = "tube.obj"\nstitch_width = 8.0\n{head}')
    (folder / "sizes.csv").write_text("size,girth [cm]\nS,110\nM,130\n")
    assert main(["run", str(folder / "job.toml"), "-o", str(folder / "job")]) == 0
    return folder
