# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""V7: drape coefficients of woven cloth (Cusick's meter), as the literature of textile measurements has them.

A round specimen of 30 cm hangs over a disc of 18 cm. The drape coefficient is the part of the free ring that its shadow
covers,

    DC = (shadow - disc) / (specimen - disc)

and a real meter shows 3 to 8 folds. The scene is ``examples/mixed/cusick.toml``. Our cloths are fabrics that Wang et
al. 2011 measured; they are not the fabrics of the published ranges. The bending length is (B / (g m))^(1/3), with the
mean rigidity B of courses and wales and the mass m of an area.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from PIL import Image, ImageDraw

from benchmarks.places import MIXED_SCENES
from benchmarks.published.comparison import Figure, Items, Section
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.drape import drape
from stitchmesh.mixed.scene.scene import read_scene
from stitchmesh.mixed.triangles.material_file import named_material
from stitchmesh.run import QUIET

EDGE = 0.5
"""Length of the edges of triangles [cm]. The scene has 1 cm, with which denim has one more fold."""
SPECIMEN, DISC = 15.0, 9.0
"""Radii of the specimen and of the disc [cm]."""
PUBLISHED: dict[str, tuple[str, tuple[float, float] | None]] = {
    "denim": ("denim, 70 to 90 %", (0.7, 0.9)),
    "plain-polyester": ("plain cotton, 60 to 76 %; one cloth 68.4 % measured", (0.6, 0.76)),
    "interlock": ("no knit was found", None),
}
"""Our cloths, and the published cloths that are most like them."""
FOLDS = (3.0, 8.0)
PIXELS = 1500
GRAVITY = 980.665
"""[cm/s^2]"""
HARMONICS = 12
"""Waves around the hem up to which folds are counted; shorter ones are triangles."""


def shadow(vertices: FloatArray, triangles: IntArray) -> float:
    """Return the area of the shadow of a cloth that light from above casts [cm^2]."""
    side = 2.2 * SPECIMEN / PIXELS
    picture = Image.new("1", (PIXELS, PIXELS))
    pen = ImageDraw.Draw(picture)
    places = vertices[:, [0, 2]] / side + PIXELS / 2
    for triangle in triangles:
        pen.polygon([tuple(place) for place in places[triangle]], fill=1)
    return float(np.asarray(picture).sum() * side**2)


def folds(vertices: FloatArray, rest: FloatArray) -> int:
    """Return how often the hem stands out."""
    hem = np.flatnonzero(np.linalg.norm(rest, axis=1) > 0.985 * SPECIMEN)
    around = hem[np.argsort(np.arctan2(rest[hem, 1], rest[hem, 0]))]
    waves = np.fft.rfft(np.linalg.norm(vertices[around][:, [0, 2]], axis=1))
    waves[HARMONICS + 1 :] = 0.0
    out = np.fft.irfft(waves, len(around))
    return int(np.sum((out > np.roll(out, 1)) & (out >= np.roll(out, -1))))


def run() -> Items:
    """Drape each cloth."""
    scene = read_scene(MIXED_SCENES / "cusick.toml")
    table: list[list[object]] = []
    for name, (like, published) in PUBLISHED.items():
        own = named_material(name)
        made = drape(replace(scene, cloth=replace(scene.cloth, material=name, edge_length=EDGE)), run=QUIET)
        vertices, cloth = np.asarray(made.end.vertices), made.prepared.fabric.cloth
        disc, specimen = np.pi * DISC**2, np.pi * SPECIMEN**2
        found = (shadow(vertices, cloth.triangles) - disc) / (specimen - disc)
        count = folds(vertices, cloth.vertices[:, [0, 2]])
        if published is not None:
            yield Figure(quantity=f"drape coefficient of {name} (published: {like})", published=published, ours=found,
                         sure="code")  # fmt: skip
        yield Figure(quantity=f"folds of {name}", published=FOLDS, ours=count, sure="code", counts=False)
        rigidity = (own.bending_course + own.bending_wale) / 2.0
        length = (rigidity / (GRAVITY * own.density)) ** (1.0 / 3.0)
        table.append([name, f"{1e4 * own.density:.0f}", f"{rigidity:.0f}", f"{length:.2f}", f"{100 * found:.0f} %",
                      count])  # fmt: skip
    yield from ("", ["cloth", "g/m2", "bending [dyn cm]", "bending length [cm]", "drape coefficient", "folds"])
    yield from table


TABLE = Section(
    name="V7", title="Drape of cloth", run=run, accepted="inside the published range, 3 to 8 folds",
    verdict="the denim that we have is limp (spandex); the interlock has one fold more than a meter usually shows",
)  # fmt: skip
