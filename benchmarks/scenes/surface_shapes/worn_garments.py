# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Garments as they are worn: y is up, the wearer looks along +z, and sizes are those of adults."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.mesh import FloatArray, Mesh

from .level_surface import Cloth, Gap, LegOpenings, Opening, Straps, Wedge
from .solids import Oval, ball, both_sides, column, flattened, joined, round_cone

UP, DOWN = (0.0, 1.0, 0.0), (0.0, -1.0, 0.0)
HEM = Opening((0.0, 0.0, 0.0), DOWN)
TORSO = [
    Oval(-6.0, 19.3, 12.1),
    Oval(0.0, 19.3, 12.1),
    Oval(38.0, 19.3, 12.1),
    Oval(44.0, 19.1, 12.0, -0.1),
    Oval(51.0, 18.2, 10.9, -0.6),
    Oval(57.0, 16.2, 9.0, -1.2),
    Oval(62.0, 11.8, 7.4, -1.5),
    Oval(66.0, 8.2, 6.6, -1.2),
    Oval(70.0, 7.0, 6.3, -0.4),
    Oval(80.0, 6.8, 6.3, 0.8),
]
"""The body above the hem of a T-shirt or a jumper, and the neck."""
NECKLINE = Opening((0.0, 65.0, 0.0), (0.0, 1.0, 0.36), 24.0)
ARMS = both_sides(round_cone((15.0, 55.5, -1.0), (73.0, 22.0, 0.0), 7.8, 4.0))
CUFFS = [Opening((side * 66.0, 26.0, 0.0), (side * 0.866, -0.5, 0.0), 14.0) for side in (-1.0, 1.0)]
"""Long sleeves that point 30 degrees down, and where they end."""
SEAT = [
    Oval(70.0, 15.0, 10.4, -0.8),
    Oval(78.0, 17.0, 11.3, -1.0),
    Oval(85.0, 17.8, 11.5, -0.9),
    Oval(94.0, 16.6, 10.9, -0.4),
    Oval(102.0, 14.9, 10.4),
    Oval(110.0, 14.6, 10.4),
]
"""Trousers above the crotch; heights are those above the cuffs."""
TROUSER_LEG = [
    Oval(-5.0, 6.0, 6.4, 0.0, 13.6),
    Oval(20.0, 6.6, 7.0, -0.2, 12.6),
    Oval(45.0, 7.6, 8.0, 0.2, 11.4),
    Oval(66.0, 8.9, 9.6, 0.0, 9.8),
    Oval(76.0, 9.2, 10.2, -0.5, 9.3),
    Oval(84.0, 8.0, 9.0, -0.5, 8.7),
    Oval(92.0, 3.0, 3.5, -0.4, 7.0),
]
HIPS = [
    Oval(71.0, 14.4, 10.2, -0.8),
    Oval(80.0, 16.2, 11.1, -1.0),
    Oval(87.0, 16.8, 11.0, -0.8),
    Oval(97.0, 14.6, 9.7, -0.2),
    Oval(104.0, 13.2, 9.1),
    Oval(112.0, 13.0, 9.0),
]
"""Leggings above the crotch; heights are those above the soles."""
TIGHT_LEG = [
    Oval(3.4, 3.4, 4.0, -1.0, 11.4),
    Oval(9.0, 3.5, 4.2, -0.8, 11.4),
    Oval(14.0, 3.7, 4.3, -0.7, 11.3),
    Oval(32.0, 5.3, 5.7, -0.8, 10.8),
    Oval(46.0, 5.4, 5.8, 0.2, 10.3),
    Oval(68.0, 8.3, 8.8, 0.0, 9.1),
    Oval(77.0, 8.8, 9.6, -0.5, 8.6),
    Oval(84.0, 7.8, 8.8, -0.5, 8.2),
    Oval(92.0, 2.5, 3.0, -0.4, 6.5),
]
FINGERS = [
    ((-3.2, 13.0, 0.0), (-5.8, 19.6, 0.0), 1.0, 0.8),
    ((-1.3, 14.0, 0.0), (-2.5, 22.4, 0.0), 1.0, 0.85),
    ((0.8, 14.0, 0.0), (1.0, 23.4, 0.0), 1.05, 0.9),
    ((2.9, 13.0, 0.0), (4.6, 22.2, 0.0), 1.0, 0.85),
]
"""Start, end, and radii at both of the fingers of a glove."""


def t_shirt(edge: float = 1.0) -> Mesh:
    """A T-shirt with lowered arms: 100 around the chest, 68 long, with sleeves of 20."""
    arms = both_sides(round_cone((15.0, 55.5, -1.0), (33.5, 37.0, 0.0), 7.4, 6.2))
    cuffs = [Opening((side * 30.5, 40.0, 0.0), (side, -1.0, 0.0), 13.0) for side in (-1.0, 1.0)]
    solid = joined([column(TORSO), *arms], 6.0)
    return Cloth(solid, (-42.0, -2.0, -15.0), (42.0, 72.0, 15.0), [HEM, NECKLINE, *cuffs]).triangles(edge)


def vest(edge: float = 1.0) -> Mesh:
    """A vest: the T-shirt without its sleeves, with armholes."""
    arms = both_sides(round_cone((15.0, 55.5, -1.0), (33.5, 37.0, 0.0), 7.4, 6.2))
    armholes = [Opening((side * 20.5, 50.0, -1.0), (side, 0.0, 0.0)) for side in (-1.0, 1.0)]
    solid = joined([column(TORSO), *arms], 6.0)
    return Cloth(solid, (-42.0, -2.0, -15.0), (42.0, 72.0, 15.0), [HEM, NECKLINE, *armholes]).triangles(edge)


def camisole(edge: float = 1.0) -> Mesh:
    """A camisole: the body below the arms, with straps of 3 over the shoulders."""
    openings = [HEM, NECKLINE, Straps(46.0, 9.6, 3.0)]
    return Cloth(column(TORSO), (-22.0, -2.0, -15.0), (22.0, 72.0, 15.0), openings).triangles(edge)


def jumper(edge: float = 1.0) -> Mesh:
    """A jumper with long sleeves that point 30 degrees down."""
    return _jumper().triangles(edge)


def cardigan(edge: float = 1.0) -> Mesh:
    """The jumper, open in front."""
    closed = _jumper()
    return replace(closed, openings=[*closed.openings, Gap(2.0)]).triangles(edge)


def v_neck_cardigan(edge: float = 1.0) -> Mesh:
    """The cardigan with a V-neck of 40, whose fronts pass into the neck without a corner."""
    closed = _jumper()
    return replace(closed, openings=[*closed.openings, Gap(2.0), Wedge(26.0, 0.25)]).triangles(edge)


def v_neck_jumper(edge: float = 1.0) -> Mesh:
    """The jumper with a V-neck of 23."""
    closed = _jumper()
    return replace(closed, openings=[*closed.openings, Wedge(42.0, 0.45)]).triangles(edge)


def hoodie(edge: float = 1.0) -> Mesh:
    """The jumper with a hood, open at the face."""
    solid = joined([column(TORSO[:8]), *ARMS, ball((0.0, 74.0, 0.0), 11.0)], 5.0)
    face = Opening((0.0, 73.0, 6.0), (0.0, 0.0, 1.0), 11.0)
    return Cloth(solid, (-72.0, -2.0, -15.0), (72.0, 88.0, 15.0), [HEM, face, *CUFFS]).triangles(edge)


def _jumper() -> Cloth:
    solid = joined([column(TORSO), *ARMS], 7.0)
    return Cloth(solid, (-72.0, -2.0, -15.0), (72.0, 72.0, 15.0), [HEM, NECKLINE, *CUFFS])


def trousers(edge: float = 1.0) -> Mesh:
    """Trousers with an open waist of 80 and an inseam of 75."""
    solid = joined([joined(both_sides(column(TROUSER_LEG)), 2.5), column(SEAT, 10.0)], 5.0)
    return Cloth(solid, (-22.0, -2.0, -16.0), (22.0, 104.0, 16.0), [HEM, waist(102.0)]).triangles(edge)


def briefs(edge: float = 1.0) -> Mesh:
    """Briefs with a waist of 94 and a crotch of 7."""
    solid = joined([joined(both_sides(column(TROUSER_LEG)), 2.5), column(SEAT, 10.0)], 5.0)
    openings = [waist(94.0), LegOpenings(66.0, 7.0, 0.9)]
    return Cloth(solid, (-22.0, 60.0, -16.0), (22.0, 98.0, 16.0), openings).triangles(edge)


def waist(height: float) -> Opening:
    """A level opening at the upper end."""
    return Opening((0.0, height, 0.0), UP)


def leggings(edge: float = 1.0) -> Mesh:
    """Leggings with closed feet and an open waist."""
    foot = round_cone((11.4, 3.6, -1.6), (13.0, 2.8, 14.0), 3.6, 2.8)
    leg = joined([column(TIGHT_LEG), foot], 3.0)
    solid = joined([joined(both_sides(leg), 2.5), column(HIPS, 10.0)], 5.0)
    return Cloth(solid, (-21.0, -2.0, -15.0), (21.0, 106.0, 19.0), [waist(104.0)]).triangles(edge)


def mitten(edge: float = 0.6) -> Mesh:
    """A mitten for a right hand, palm forwards, with an open cuff."""
    wrist = round_cone((0.0, -8.0, 0.0), (0.0, 6.0, 0.0), 4.0, 4.2)
    palm = flattened(joined([wrist, round_cone((0.0, 12.0, 0.0), (0.0, 20.0, 0.0), 5.0, 4.4)], 8.0), 1.7)
    thumb = round_cone((2.6, 8.0, 0.6), (7.4, 15.5, 1.6), 2.1, 1.6)
    return Cloth(joined([palm, thumb], 2.5), (-7.0, -1.0, -5.0), (11.0, 26.5, 6.0), [HEM]).triangles(edge)


def glove(edge: float = 0.5) -> Mesh:
    """A glove for a right hand, palm forwards, with five closed fingers and an open cuff."""
    wrist = round_cone((0.0, -8.0, 0.0), (0.0, 4.0, 0.0), 3.5, 3.5)
    palm = flattened(joined([wrist, round_cone((0.0, 9.5, 0.0), (0.0, 11.5, 0.0), 4.3, 4.2)], 6.0), 1.8)
    thumb = round_cone((2.0, 5.5, 0.5), (6.8, 14.5, 1.6), 1.6, 0.95)
    solid = joined([palm, thumb, *(round_cone(*finger) for finger in FINGERS)], 1.1)
    return Cloth(solid, (-8.0, -1.0, -4.0), (9.0, 26.0, 5.0), [HEM], 0.7).triangles(edge)


def beanie(edge: float = 1.0) -> Mesh:
    """A beanie for a head of 56: a tube with a round crown, open at the bottom."""
    radii = np.array([8.5, 11.0, 9.4])

    def value(points: FloatArray) -> FloatArray:
        above = np.maximum(points - np.array([0.0, 11.0, 0.0]), np.array([-np.inf, 0.0, -np.inf]))
        return 8.5 * (np.linalg.norm(above / radii, axis=-1) - 1.0)

    return Cloth(value, (-11.0, -2.0, -12.0), (11.0, 25.0, 12.0), [HEM]).triangles(edge)


WORN = (
    t_shirt, jumper, trousers, leggings, mitten, glove, beanie, cardigan, vest, hoodie, v_neck_jumper, v_neck_cardigan,
    camisole, briefs,
)  # fmt: skip
