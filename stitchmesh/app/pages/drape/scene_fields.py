# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The fields of a scene that the page Drape shows: equilibrium or motion, materials, densities, precision, device."""

from __future__ import annotations

from stitchmesh.app.controls.field_panel import Number, Words, same_words, setting_field
from stitchmesh.compute.device import device_names
from stitchmesh.io.toml_file import read_table
from stitchmesh.mixed.crossings.crossing_material import DEFAULT, CrossingMaterial
from stitchmesh.mixed.scene.cloth_of_yarns import MATCHED
from stitchmesh.mixed.scene.cloth_section import ClothSection
from stitchmesh.mixed.scene.scene import Scene, SolverSection
from stitchmesh.mixed.scene.scene_fabric import STITCHES
from stitchmesh.mixed.scene.yarns_section import YarnsSection
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


def is_weave(scene: Scene) -> bool:
    """Return whether the yarns of a scene are a weave."""
    return scene.yarns.weave is not None


def is_knit(scene: Scene) -> bool:
    """Return whether the yarns of a scene are stitches of their own, and not the stitches of the cloth."""
    return scene.yarns.weave is None and scene.yarns.knit != STITCHES


def has_loops(scene: Scene) -> bool:
    """Return whether the yarns of a scene follow stitches of the cloth, as crossings."""
    return scene.yarns.knit == STITCHES and scene.yarns.model == "crossings"


SCENE_FIELDS = (
    setting_field(Scene, "mode", "The cloth", MODES),
    setting_field(Scene, "duration", "Time", Number(1e-4, 3600.0, 0.05)),
    setting_field(YarnsSection, "material", "Yarn", yarn_materials, at="yarns.material"),
    setting_field(ClothSection, "material", "Cloth",
                  {"from the yarns": None, **same_words((MATCHED, *material_names()))}, at="cloth.material"),
    setting_field(YarnsSection, "ends", "Warps per cm", DENSITY, at="yarns.ends", shown=is_weave),
    setting_field(YarnsSection, "picks", "Wefts per cm", DENSITY, at="yarns.picks", shown=is_weave),
    setting_field(YarnsSection, "wales", "Wales per cm", DENSITY, at="yarns.wales", shown=is_knit),
    setting_field(YarnsSection, "courses", "Courses per cm", DENSITY, at="yarns.courses", shown=is_knit),
    setting_field(YarnsSection, "divisions", "Loops per stitch", Number(1, 20, 1), at="yarns.divisions",
                  shown=has_loops),
    setting_field(SolverSection, "precision", "Precision", same_words(("float64", "float32")), at="solver.precision"),
    setting_field(SolverSection, "device", "Device", lambda scene: {"automatic": None, **same_words(device_names())},
                  at="solver.device"),
)  # fmt: skip
"""The fields of a scene that the page shows."""
