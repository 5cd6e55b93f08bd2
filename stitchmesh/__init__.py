# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""StitchMesh: from a polygon mesh of a garment to knitted, relaxed yarns.

Names are loaded when first used, so that importing the package, and asking the command line for help, stays fast.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

# the one function that shares its name with its package: bound now, before any import can bind the package
from stitchmesh.tessellate import tessellate

if TYPE_CHECKING:
    from stitchmesh.editing.edit import Edit, apply_edit
    from stitchmesh.editing.history import History
    from stitchmesh.editing.log import replay_edits
    from stitchmesh.editing.spiral import make_spiral
    from stitchmesh.errors import StitchMeshError
    from stitchmesh.hand_knitting import knitting_instructions
    from stitchmesh.io import (
        read_mesh,
        read_stitches,
        read_yarns,
        write_mesh,
        write_stitches,
        write_yarns,
    )
    from stitchmesh.labeling import label
    from stitchmesh.lattice import Lattice
    from stitchmesh.mesh import Mesh, StitchMesh
    from stitchmesh.mesh.stitch import Stitch
    from stitchmesh.meshrelax import relax_mesh
    from stitchmesh.patterns import Pattern, apply_pattern, parse_pattern, pattern_mesh, pattern_names, read_pattern
    from stitchmesh.periodic.resolve_pattern import resolve_pattern
    from stitchmesh.periodic.session.session import SwatchSession
    from stitchmesh.periodic.stretch import StretchCurve, stretch_test
    from stitchmesh.periodic.swatch import Swatch, swatch
    from stitchmesh.periodic.textures.textures import texture_maps
    from stitchmesh.periodic.torus import torus_mesh
    from stitchmesh.periodic.weave.library import read_weave, weave_names
    from stitchmesh.periodic.weave.weave import Weave
    from stitchmesh.periodic.weave.yarns import weave_yarns
    from stitchmesh.quality import Quality
    from stitchmesh.yarn import YarnSet
    from stitchmesh.yarn.radius_estimate import estimate_radius
    from stitchmesh.yarn.rest_length import RestLengths, apply_rest_lengths
    from stitchmesh.yarn.tiling import tile_yarns
    from stitchmesh.yarngen import YarnFinish, check_loops, generate_yarns, regenerate_yarns
    from stitchmesh.yarnrelax import (
        RelaxCell,
        YarnMaterial,
        linking_certificate,
        relax_yarns,
        yarn_energies,
        yarn_forces,
    )
    from stitchmesh.yarnrelax.checkpoint import Checkpoints
    from stitchmesh.yarnrelax.constraints.pins import Pins
    from stitchmesh.yarnrelax.energies.body import Body
    from stitchmesh.yarnrelax.energies.friction import Friction
    from stitchmesh.yarnrelax.energies.gravity import Gravity
    from stitchmesh.yarnrelax.energies.point_load import PointLoad
    from stitchmesh.yarnrelax.energies.twist import Twist
    from stitchmesh.yarnrelax.relax_cells import relax_cells

__version__ = "0.1.0"

_HOME = {
    "Edit": "editing.edit",
    "apply_edit": "editing.edit",
    "History": "editing.history",
    "replay_edits": "editing.log",
    "make_spiral": "editing.spiral",
    "StitchMeshError": "errors",
    "knitting_instructions": "hand_knitting",
    "read_mesh": "io",
    "read_stitches": "io",
    "read_yarns": "io",
    "write_mesh": "io",
    "write_stitches": "io",
    "write_yarns": "io",
    "label": "labeling",
    "Lattice": "lattice",
    "Mesh": "mesh",
    "StitchMesh": "mesh",
    "relax_mesh": "meshrelax",
    "Pattern": "patterns",
    "apply_pattern": "patterns",
    "parse_pattern": "patterns",
    "pattern_mesh": "patterns",
    "pattern_names": "patterns",
    "read_pattern": "patterns",
    "SwatchSession": "periodic.session.session",
    "resolve_pattern": "periodic.resolve_pattern",
    "StretchCurve": "periodic.stretch",
    "stretch_test": "periodic.stretch",
    "Swatch": "periodic.swatch",
    "swatch": "periodic.swatch",
    "texture_maps": "periodic.textures.textures",
    "torus_mesh": "periodic.torus",
    "Weave": "periodic.weave.weave",
    "read_weave": "periodic.weave.library",
    "weave_names": "periodic.weave.library",
    "weave_yarns": "periodic.weave.yarns",
    "Quality": "quality",
    "RestLengths": "yarn.rest_length",
    "apply_rest_lengths": "yarn.rest_length",
    "Stitch": "mesh.stitch",
    "tile_yarns": "yarn.tiling",
    "YarnSet": "yarn",
    "estimate_radius": "yarn.radius_estimate",
    "YarnFinish": "yarngen",
    "check_loops": "yarngen",
    "generate_yarns": "yarngen",
    "regenerate_yarns": "yarngen",
    "RelaxCell": "yarnrelax",
    "YarnMaterial": "yarnrelax",
    "linking_certificate": "yarnrelax",
    "relax_cells": "yarnrelax.relax_cells",
    "relax_yarns": "yarnrelax",
    "yarn_energies": "yarnrelax",
    "yarn_forces": "yarnrelax",
    "Body": "yarnrelax.energies.body",
    "Checkpoints": "yarnrelax.checkpoint",
    "Friction": "yarnrelax.energies.friction",
    "Gravity": "yarnrelax.energies.gravity",
    "Pins": "yarnrelax.constraints.pins",
    "PointLoad": "yarnrelax.energies.point_load",
    "Twist": "yarnrelax.energies.twist",
}
"""Module of each public name."""

__all__ = [
    "Body",
    "Checkpoints",
    "Edit",
    "Friction",
    "Gravity",
    "History",
    "Lattice",
    "Mesh",
    "Pattern",
    "Pins",
    "PointLoad",
    "Quality",
    "RelaxCell",
    "RestLengths",
    "Stitch",
    "StitchMesh",
    "StitchMeshError",
    "StretchCurve",
    "Swatch",
    "SwatchSession",
    "Twist",
    "Weave",
    "YarnFinish",
    "YarnMaterial",
    "YarnSet",
    "apply_edit",
    "apply_pattern",
    "apply_rest_lengths",
    "check_loops",
    "estimate_radius",
    "generate_yarns",
    "knitting_instructions",
    "label",
    "linking_certificate",
    "make_spiral",
    "parse_pattern",
    "pattern_mesh",
    "pattern_names",
    "read_mesh",
    "read_pattern",
    "read_stitches",
    "read_weave",
    "read_yarns",
    "regenerate_yarns",
    "relax_cells",
    "relax_mesh",
    "relax_yarns",
    "replay_edits",
    "resolve_pattern",
    "stretch_test",
    "swatch",
    "tessellate",
    "texture_maps",
    "tile_yarns",
    "torus_mesh",
    "weave_names",
    "weave_yarns",
    "write_mesh",
    "write_stitches",
    "write_yarns",
    "yarn_energies",
    "yarn_forces",
]


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module 'stitchmesh' has no attribute {name!r}")
    return getattr(import_module(f"stitchmesh.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
