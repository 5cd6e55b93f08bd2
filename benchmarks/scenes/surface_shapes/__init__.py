# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Surfaces of triangles that follow no rows of knitting, from simple shapes to garments as they are worn."""

from __future__ import annotations

from collections.abc import Callable

from stitchmesh.mesh import Mesh

from .flat_sheets import annulus_disc, box, flat_disc, flat_square, moebius_polygons
from .simple_surfaces import (
    bent_tube,
    capsule,
    closed_cone,
    cylinder,
    dome,
    frustum,
    genus_2,
    s_tube,
    sphere,
    t_junction,
    torus,
    y_junction,
)
from .soft_toys import bear, octopus
from .triangulation import triangulated
from .worn_garments import (
    beanie,
    briefs,
    camisole,
    cardigan,
    glove,
    hoodie,
    jumper,
    leggings,
    mitten,
    t_shirt,
    trousers,
    v_neck_cardigan,
    v_neck_jumper,
    vest,
)

SHAPES: dict[str, Callable[[], Mesh]] = {
    shape.__name__: shape
    for shape in (
        cylinder,
        frustum,
        closed_cone,
        dome,
        sphere,
        torus,
        bent_tube,
        s_tube,
        t_junction,
        y_junction,
        genus_2,
        capsule,
        box,
        flat_square,
        flat_disc,
        annulus_disc,
        t_shirt,
        jumper,
        trousers,
        leggings,
        mitten,
        glove,
        beanie,
        cardigan,
        vest,
        hoodie,
        v_neck_jumper,
        v_neck_cardigan,
        camisole,
        briefs,
        bear,
        octopus,
    )
}
"""All shapes by the names of their functions, which also take the length of edges [cm]."""

__all__ = ["SHAPES", "moebius_polygons", "triangulated"]
