# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The B-spline yarns of a scene: generated from the stitches of its cloth, relaxed, and laid out on the cloth.

The relaxation keeps the borders and the shape of the stitch mesh, so the yarns lie where their stitches are. It gives
all yarns the shape of loops at rest, also where triangles are simulated and yarns are only shown.
"""

from __future__ import annotations

from dataclasses import replace

from stitchmesh.mesh import StitchMesh
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.layout.spline_yarns import SplineYarns, lay_splines
from stitchmesh.mixed.scene.scene import YarnsSection
from stitchmesh.mixed.splines.spline_pieces import SplineMaterial
from stitchmesh.quality import quality_named
from stitchmesh.run import QUIET
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.rest_length import RestLengths, apply_rest_lengths
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarnrelax import relax_yarns
from stitchmesh.yarnrelax.model.material import DEFAULT_MATERIAL

QUALITY = replace(quality_named("draft"), contact_samples=SplineMaterial.contact_samples)
"""Quality of the yarns: 12 control points for each stitch. The loops of a swatch are then 1 % larger than at quality
``reference``."""


def lay_scene_splines(section: YarnsSection, fabric: StitchMesh, cloth: Cloth, device: str | None) -> SplineYarns:
    """Return the B-spline yarns of a scene.

    Args:
        section: the yarns of the scene.
        fabric: the stitch mesh of the cloth of the scene.
        cloth: the cloth of the stitch mesh.
        device: name of the device that relaxes the yarns; by default a GPU if there is one.

    Raises:
        ParameterError: a radius or a loop length does not fit the stitches.
        YarnError: a stitch has no yarn.
        SolverError: the yarns are too close to one another.
    """
    curves = drawn_splines(section, fabric)
    material = spline_material(section, float(curves.radius.mean())).yarn
    relaxed = relax_yarns(curves, material=material, quality=QUALITY, keep_shape=fabric, device=device, run=QUIET)
    return lay_splines(cloth, fabric, relaxed.yarns)


def drawn_splines(section: YarnsSection, fabric: StitchMesh) -> YarnSet:
    """Return the B-spline yarns as generated, with rest lengths; arguments and errors as in ``lay_scene_splines``."""
    drawn = generate_yarns(fabric, yarn_radius=section.radius, quality=QUALITY)
    return apply_rest_lengths(drawn, RestLengths(loop_length=section.loop_length), fabric=fabric)


def spline_material(section: YarnsSection, radius: float) -> SplineMaterial:
    """Return the material of the B-spline yarns of a scene, for their radius [cm].

    Raises:
        ParameterError: there is no material of that name.
    """
    return SplineMaterial.named(section.material or DEFAULT_MATERIAL, radius=radius)
