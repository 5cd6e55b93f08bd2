# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The fields of a scene that the page Drape shows: equilibrium or motion, materials, densities, precision, device."""

from __future__ import annotations

from stitchmesh.app.controls.field_panel import Field, Number, Words, same_words
from stitchmesh.compute.device import device_names
from stitchmesh.io.toml_file import read_table
from stitchmesh.mixed.crossings.crossing_material import DEFAULT, CrossingMaterial
from stitchmesh.mixed.scene.cloth_of_yarns import MATCHED
from stitchmesh.mixed.scene.scene import Scene
from stitchmesh.mixed.scene.scene_fabric import STITCHES
from stitchmesh.mixed.triangles.material_file import material_names

MODES = {"comes to rest": "static", "moves": "dynamic"}
"""The two modes of a scene, by the words of the page."""
DENSITY = Number(0.1, 1000.0, 0.5)
"""Yarns or stitches for each cm."""


def yarn_materials(scene: Scene) -> Words:
    """Return the materials that the yarns of a scene can have; a scene without a named material has the default."""
    file = scene.yarns.material_file
    names = CrossingMaterial.names() if file is None else tuple(read_table(file))
    return {name: None if name == DEFAULT and scene.yarns.material is None else name for name in names}


def is_knit(scene: Scene) -> bool:
    """Return whether the yarns of a scene are stitches of their own, and not the stitches of the cloth."""
    return scene.yarns.weave is None and scene.yarns.knit != STITCHES


def has_loops(scene: Scene) -> bool:
    """Return whether the yarns of a scene follow stitches of the cloth, as crossings."""
    return scene.yarns.knit == STITCHES and scene.yarns.model == "crossings"


SCENE_FIELDS = (
    Field("mode", "The cloth", "An equilibrium, or a motion in time.", MODES),
    Field("duration", "Time", "Time of the motion, or of the last keyframe [s].", Number(1e-4, 3600.0, 0.05)),
    Field("yarns.material", "Yarn", "Material of the yarns.", yarn_materials),
    Field("cloth.material", "Cloth", "Material of the triangles.",
          {"from the yarns": None, **same_words((MATCHED, *material_names()))}),
    Field("yarns.ends", "Warps per cm", "Warps for each cm.", DENSITY, lambda scene: scene.yarns.weave is not None),
    Field("yarns.picks", "Wefts per cm", "Wefts for each cm.", DENSITY, lambda scene: scene.yarns.weave is not None),
    Field("yarns.wales", "Wales per cm", "Stitches of a row for each cm.", DENSITY, is_knit),
    Field("yarns.courses", "Courses per cm", "Rows of stitches for each cm.", DENSITY, is_knit),
    Field("yarns.divisions", "Loops per stitch", "Loops along each side of a stitch of the cloth.", Number(1, 20, 1),
          has_loops),
    Field("solver.precision", "Precision", "float32 is faster on a GPU.", same_words(("float64", "float32"))),
    Field("solver.device", "Device", "Processor of the run; automatic takes a GPU if there is one.",
          lambda scene: {"automatic": None, **same_words(device_names())}),
)  # fmt: skip
"""The fields of a scene that the page shows."""
