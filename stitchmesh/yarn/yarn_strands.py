# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The strands of yarns: plies, fibres and fibres that stand off, as curves with radii and colours.

The plies of a yarn of n plies are circles inside its body. With the radius R of the body, a ply has the radius

    r = fullness R / (1 + 1 / sin(pi / n)),

and its centre line has the distance R - r from the centre line of the yarn, so that the plies reach to R. The helices
of the plies turn once in the lay, relative to the twist-free frame of the yarn. The fibres of a single yarn turn with
its twist. Those of a ply turn against it, by the angle at which the fibres on the outside lie along the yarn, as in a
yarn that hangs without a torque.

Thickness, colours and hair follow from hashed numbers of the yarn and the place along it: the same yarn always has the
same strands. On a yarn that is closed, or that continues in a copy of itself, the numbers of turns and of cells of
noise are whole, so that strands and colours continue over the joint.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.palette import colours_of, linear_colour, parse_colour, srgb_colour
from stitchmesh.mesh.tube_mesh import twist_free_frames
from stitchmesh.yarn.polyline import polylines_of_segments
from stitchmesh.yarn.yarn_look import OWN, YarnLook
from stitchmesh.yarn.yarn_set import YarnSet

PLY, FIBRE, HAIR = 0, 1, 2
"""Kinds of strands."""
POINTS_PER_TURN = 10
"""Fewest points of a ply in one turn."""
POINTS_OF_HAIR = 7
"""Points of a fibre that stands off."""
FIBRE_SHARE = 0.1
"""Part of the cross-section that fibres fill: 690 fibres of 25 um in the yarn dk, which is 2.03 mm thick."""
LONG_WAVES, SHORT_WAVES = 8.0, 2.0
"""Lengths of the cells of noise over the diameter of the yarn."""
NEP_LENGTH, NEP_THICKNESS = 0.28, 1.3
"""Half the length of a fleck over the diameter of the yarn, and thickness of the ply in its middle."""
HASHED_VARIANCE = 26.0 / 35.0
"""Mean variance of noise between cells of variance 1, the integral of w^2 + (1 - w)^2 for w = 3 t^2 - 2 t^3."""
THICKNESS, SHADE, HAIRS, FLECKS, WANDER, PLACES = range(1, 7)
"""Channels of hashed numbers."""


@dataclass(frozen=True, eq=False)
class YarnStrands:
    """Curves of the strands of yarns: C curves with P points."""

    points: FloatArray
    """Points of all curves in turn [cm], shape (P, 3)."""
    outward: FloatArray
    """Unit vectors away from the middle of the yarn or, on a fibre, of its ply, shape (P, 3)."""
    radius: FloatArray
    """Radius of each point [cm], shape (P,)."""
    colour: NDArray[np.uint8]
    """Colour of each point (sRGB), shape (P, 3)."""
    start: IntArray
    """First point of each curve, and P at the end, shape (C + 1,)."""
    closed: NDArray[np.bool_]
    """Whether the last point of each curve continues at the first one, displaced by ``shift``, shape (C,)."""
    shift: FloatArray
    """Displacement of the copy in which each closed curve continues [cm], shape (C, 3)."""
    kind: IntArray
    """``PLY``, ``FIBRE`` or ``HAIR`` of each curve, shape (C,)."""
    yarn: IntArray
    """Yarn of each curve, shape (C,)."""


@dataclass(frozen=True, eq=False)
class _Lines:
    """Centre lines of yarns: c curves with p points."""

    points: FloatArray
    along: FloatArray
    """Place of each point on its yarn [diameters], shape (p,)."""
    total: FloatArray
    """Length of the yarn of each point [diameters], shape (p,)."""
    repeats: NDArray[np.bool_]
    """Whether the yarn of each point is closed, shape (p,)."""
    yarn: IntArray
    """Yarn of each point, shape (p,)."""
    diameter: FloatArray
    """Apparent diameter of the yarn of each point [cm], shape (p,)."""
    colour: FloatArray
    """Colour of each point in linear light, shape (p, 3)."""
    across: FloatArray
    upward: FloatArray
    start: IntArray
    closed: NDArray[np.bool_]
    shift: FloatArray


def yarn_strands(
    yarns: YarnSet, look: YarnLook, *, segments: IntArray | None = None, samples: int = 3, fibres: int = 0,
    hair: float = 0.0, colours: NDArray[np.uint8] | None = None,
) -> YarnStrands:  # fmt: skip
    """Make the strands of yarns from their centre lines.

    Args:
        yarns: the yarns.
        look: how they look.
        segments: numbers of the segments, ascending; all by default. Strands of a part lie as those of the whole, but
            for a turn about the yarn.
        samples: points per segment; plies get more where a turn needs them.
        fibres: number of fibres of each ply.
        hair: part of the fibres that stand off, from 0 to 1.
        colours: colour of each control point (sRGB), shape (N, 3); the colours of the yarns by default.
    """
    chosen = np.arange(len(yarns.segment_points)) if segments is None else segments
    painted = colours_of(yarns.colour, yarns.palette)[yarns.point_yarn] if colours is None else colours
    lines = _lines(yarns, look, chosen, samples, painted)
    parts = [_ply_of(lines, look, ply) for ply in range(look.plies)]
    if fibres:
        parts += [_fibres_of(lines, look, ply, parts[ply], fibres) for ply in range(look.plies)]
    if hair and look.hair_density and look.hair_length:
        parts += _hair_of(lines, look, hair)
    return _joined(parts)


def _joined(parts: Sequence[YarnStrands]) -> YarnStrands:
    """Return the curves of several sets of strands as one set."""
    first = np.cumsum([0, *(len(part.points) for part in parts)])
    starts = [part.start[:-1] + begin for part, begin in zip(parts, first[:-1], strict=True)]
    return YarnStrands(
        points=np.concatenate([part.points for part in parts]),
        outward=np.concatenate([part.outward for part in parts]),
        radius=np.concatenate([part.radius for part in parts]),
        colour=np.concatenate([part.colour for part in parts]),
        start=np.concatenate([*starts, first[-1:]]),
        closed=np.concatenate([part.closed for part in parts]),
        shift=np.concatenate([part.shift for part in parts]),
        kind=np.concatenate([part.kind for part in parts]),
        yarn=np.concatenate([part.yarn for part in parts]),
    )


def _lines(
    yarns: YarnSet, look: YarnLook, segments: IntArray, samples: int, colours: NDArray[np.uint8]
) -> _Lines:
    """Sample the centre lines; a curve that continues in a copy of itself leaves out the point of the copy."""
    turns = float(np.median(yarns.lengths)) / (look.lay * 2.0 * float(np.median(yarns.drawn_radius)))
    samples = max(samples, int(np.ceil(POINTS_PER_TURN * turns))) if look.plies > 1 else samples
    found = polylines_of_segments(yarns, segments, samples)
    counts = np.array([len(curve) for curve in found.points])
    first = np.concatenate([[0], np.cumsum(counts)])
    whole = (counts - 1) // samples == np.diff(yarns.segment_start)[found.yarn]
    lattice = whole & yarns.closed[found.yarn] & ~np.array(found.closed)
    kept = np.ones(first[-1], dtype=np.bool_)
    kept[first[1:][lattice] - 1] = False
    place = np.arange(first[-1]) - np.repeat(first[:-1], counts)
    segment = np.repeat(found.segment[first[:-1]], counts) + place // samples
    reached = np.concatenate([[0.0], np.cumsum(yarns.lengths)])
    step = np.append(yarns.lengths, 0.0)[segment] * (place % samples) / samples
    owner = np.repeat(found.yarn, counts)[kept]
    diameter = 2.0 * yarns.drawn_radius[owner]
    begins = reached[yarns.segment_start]
    closed, shift = np.array(found.closed) | lattice, np.zeros((len(counts), 3))
    if yarns.lattice is not None and yarns.lattice_step is not None:
        shift[lattice] = yarns.lattice.shift(yarns.lattice_step)[found.yarn[lattice]]
    curves = [curve[: len(curve) - cut] for curve, cut in zip(found.points, lattice.astype(int).tolist(), strict=True)]
    across, upward = twist_free_frames(curves, closed, shift)
    return _Lines(
        points=np.concatenate(curves), along=((reached[segment] + step)[kept] - begins[owner]) / diameter,
        total=np.diff(begins)[owner] / diameter, repeats=yarns.closed[owner], yarn=owner, diameter=diameter,
        colour=linear_colour(colours[found.control_point[kept]] / 255), across=across, upward=upward,
        start=np.concatenate([[0], np.cumsum(counts - lattice)]), closed=closed, shift=shift,
    )  # fmt: skip


def _ply_of(lines: _Lines, look: YarnLook, ply: int) -> YarnStrands:
    """Return the curves of one ply of all yarns."""
    whole = look.body * 0.5 * lines.diameter * _thickness(lines, look)
    radius = look.fullness * whole / (1.0 + 1.0 / np.sin(np.pi / look.plies)) if look.plies > 1 else whole
    angle = (_turned(lines, look) + 2.0 * np.pi * ply / look.plies)[:, None]
    out = np.cos(angle) * lines.across + np.sin(angle) * lines.upward
    flecked, colour = _flecks(lines, look, ply, _shaded(lines, look, ply))
    bulge = 1.0 + (NEP_THICKNESS - 1.0) * flecked
    return _strands(lines, lines.points + (whole - radius)[:, None] * out, out, bulge * radius, colour, PLY)


def _fibres_of(lines: _Lines, look: YarnLook, ply: int, of: YarnStrands, count: int) -> YarnStrands:
    """Return fibres of one ply; each wanders between the middle and the surface of the ply."""
    apart = 1.0 + 1.0 / np.sin(np.pi / look.plies) if look.plies > 1 else 1.0
    share = look.fullness / apart if look.plies > 1 else 1.0
    turns = _turned(lines, look) if look.plies == 1 else -_turned(lines, look, (1.0 - share) / share)
    thin = of.radius * np.sqrt(FIBRE_SHARE / max(look.fibres / look.plies, 1.0))
    parts = []
    for fibre in range(count):
        number = np.full(1, 1000 * ply + fibre)
        angle = (turns + 2.0 * np.pi * _hashed(number, number, PLACES)[0])[:, None]
        out = np.cos(angle) * lines.across + np.sin(angle) * lines.upward
        usual = np.sqrt(0.4 + 0.6 * _hashed(number, number, WANDER)[0])
        wander = 0.5 * look.migration * _noise(lines, LONG_WAVES, 64 + int(number[0])) * 0.3
        reach = np.clip(usual + wander, 0.0, 1.04) * of.radius
        shade = np.exp(look.heather * 2.0 * (_hashed(number, number, SHADE)[0] - 0.5) * np.sqrt(3.0))
        colour = _bytes(linear_colour(of.colour / 255) * shade)
        parts.append(_strands(lines, of.points + reach[:, None] * out, out, thin, colour, FIBRE))
    return _joined(parts)


def _hair_of(lines: _Lines, look: YarnLook, part: float) -> list[YarnStrands]:
    """Return the fibres that stand off, in one piece; none if no root lies on the curves."""
    root, number = [], []
    for first, last in zip(lines.start[:-1].tolist(), lines.start[1:].tolist(), strict=True):
        rate = look.hair_density * part
        if lines.repeats[first]:
            rate = max(round(rate * lines.total[first]), 1) / lines.total[first]
        cells = np.arange(int(np.ceil(lines.along[first] * rate)), int(np.floor(lines.along[last - 1] * rate)))
        yarn = np.full(len(cells), lines.yarn[first])
        place = (cells + 0.5 + 0.9 * (_hashed(yarn, cells, PLACES) - 0.5)) / rate
        root.append(np.interp(place, lines.along[first:last], np.arange(first, last)))
        number.append(cells)
    places, cell = np.concatenate(root), np.concatenate(number)
    if not len(places):
        return []
    below = np.floor(places).astype(np.int64)
    nearby, yarn = (places - below)[:, None], lines.yarn[below]
    above = np.minimum(below + 1, len(lines.points) - 1)
    dice = [_hashed(yarn, cell, 16 * HAIRS + channel) for channel in range(9)]
    angle = 2.0 * np.pi * dice[0][:, None]
    out = np.cos(angle) * lines.across[below] + np.sin(angle) * lines.upward[below]
    aside = np.cos(angle) * lines.upward[below] - np.sin(angle) * lines.across[below]
    forward = np.cross(lines.across[below], lines.upward[below])
    length = look.hair_length * lines.diameter[below] * np.minimum(0.3 - 0.7 * np.log(1.0 - 0.999 * dice[1]), 3.0)
    time = (np.arange(POINTS_OF_HAIR) / (POINTS_OF_HAIR - 1))[:, None, None]
    signed = [2.0 * one[:, None] - 1.0 for one in dice[2:]]
    ways = (0.35 + 0.6 * dice[8][:, None]) * out + 1.2 * signed[0] * forward + 0.6 * signed[1] * aside
    bend = signed[2] * out + 1.6 * signed[3] * forward + 1.6 * signed[4] * aside
    curl = signed[5] * out + 1.2 * signed[1] * forward - 1.2 * signed[0] * aside
    heading = ways + time * bend + time**2 * curl
    heading /= np.maximum(np.linalg.norm(heading, axis=2, keepdims=True), 1e-9)
    steps = np.concatenate([np.zeros((1, *heading.shape[1:])), np.cumsum(heading[:-1], axis=0)]) / (POINTS_OF_HAIR - 1)
    base = lines.points[below] + nearby * (lines.points[above] - lines.points[below])
    base = base + 0.85 * look.body * 0.5 * lines.diameter[below, None] * out
    points = (base + length[:, None] * steps).transpose(1, 0, 2).reshape(-1, 3)
    body = look.body * 0.5 * lines.diameter[below]
    thin = body * np.sqrt(FIBRE_SHARE / max(look.fibres, 1)) if look.fibres else 0.02 * body
    shade = np.exp(look.heather * (2.0 * dice[7] - 1.0) * np.sqrt(3.0))[:, None]
    count = len(places)
    return [YarnStrands(
        points=points, outward=np.repeat(out, POINTS_OF_HAIR, axis=0), radius=np.repeat(thin, POINTS_OF_HAIR),
        colour=np.repeat(_bytes(_shaded(lines, look, 0)[below] * shade), POINTS_OF_HAIR, axis=0),
        start=POINTS_OF_HAIR * np.arange(count + 1), closed=np.zeros(count, dtype=np.bool_),
        shift=np.zeros((count, 3)), kind=np.full(count, HAIR), yarn=yarn,
    )]  # fmt: skip


def _turned(lines: _Lines, look: YarnLook, factor: float = 1.0) -> FloatArray:
    """Angle by which the plies have turned at each point, shape (p,); a closed yarn has a whole number of turns."""
    turns = factor * lines.total / look.lay
    turns = np.where(lines.repeats, np.maximum(np.round(turns), 1.0 if factor == 1.0 else 0.0), turns)
    angle: FloatArray = (-2.0 if look.twist == "S" else 2.0) * np.pi * turns * lines.along / lines.total
    return angle


def _thickness(lines: _Lines, look: YarnLook) -> FloatArray:
    """Thickness of the yarn at each point over its mean, shape (p,)."""
    if not look.unevenness:
        return np.ones(len(lines.points))
    both = (_noise(lines, LONG_WAVES, THICKNESS) + _noise(lines, SHORT_WAVES, THICKNESS + 32)) / np.sqrt(2.0)
    return 1.0 + look.unevenness * np.clip(both, -2.5, 2.5)


def _shaded(lines: _Lines, look: YarnLook, ply: int) -> FloatArray:
    """Colour of a ply in linear light, with marl, colours along the yarn and shade, shape (p, 3)."""
    colour = lines.colour
    if look.variegation:
        times = lines.total / look.colour_length
        times = np.where(lines.repeats, np.maximum(np.round(times), 1.0), times)
        place = len(look.variegation) * np.mod(times * lines.along / lines.total, 1.0)
        table = np.stack([_colour(text, lines.colour) for text in (*look.variegation, look.variegation[0])])
        low, points = np.minimum(place.astype(np.int64), len(look.variegation) - 1), np.arange(len(place))
        colour = table[low, points] + (place - low)[:, None] * (table[low + 1, points] - table[low, points])
    if look.marl and look.marl[ply % len(look.marl)] != OWN:
        colour = _colour(look.marl[ply % len(look.marl)], lines.colour)
    if look.heather:
        # a ply shows the mean of some fibres, which differs less than the fibres
        colour = colour * np.exp(0.5 * look.heather * _noise(lines, 0.25 * SHORT_WAVES, 32 * SHADE + ply))[:, None]
    return np.minimum(colour, 1.0)


def _colour(text: str, own: FloatArray) -> FloatArray:
    return own if text == OWN else np.broadcast_to(linear_colour(parse_colour(text) / 255), own.shape)


def _flecks(lines: _Lines, look: YarnLook, ply: int, colour: FloatArray) -> tuple[FloatArray, NDArray[np.uint8]]:
    """Return how far each point lies in a fleck, from 0 to 1, shape (p,), and the colours with the flecks."""
    if not look.neps:
        return np.zeros(len(colour)), _bytes(colour)
    cells, place = _cells(lines, 2.0 * NEP_LENGTH)
    number = np.floor(place).astype(np.int64) % cells
    chosen = _hashed(lines.yarn, number, FLECKS + 32 * (ply + 1)) < 2.0 * NEP_LENGTH * look.neps / look.plies
    inside = np.where(chosen, 1.0 - np.square(2.0 * (place - np.floor(place)) - 1.0), 0.0)
    dyes = np.stack([linear_colour(parse_colour(text) / 255) for text in look.nep_colours if text != OWN])
    which = (_hashed(lines.yarn, number, FLECKS + 640) * len(dyes)).astype(np.int64)
    share = np.minimum(2.5 * inside, 1.0)[:, None]
    return inside, _bytes((1.0 - share) * colour + share * dyes[which])


def _cells(lines: _Lines, length: float) -> tuple[IntArray, FloatArray]:
    """Return the number of cells of a length [diameters] on the yarn of each point, and the place counted in cells."""
    count = np.maximum(np.round(lines.total / length), 1.0)
    return count.astype(np.int64), lines.along / lines.total * count


def _noise(lines: _Lines, length: float, channel: int) -> FloatArray:
    """Smooth noise along the yarns with mean 0 and variance 1, shape (p,)."""
    cells, place = _cells(lines, length)
    low = np.floor(place).astype(np.int64)
    t = place - low
    weight = t * t * (3.0 - 2.0 * t)
    ends = [np.sqrt(12.0) * (_hashed(lines.yarn, (low + one) % cells, channel) - 0.5) for one in (0, 1)]
    noise: FloatArray = ((1.0 - weight) * ends[0] + weight * ends[1]) / np.sqrt(HASHED_VARIANCE)
    return noise


def _hashed(yarn: ArrayLike, cell: ArrayLike, channel: int) -> FloatArray:
    """Return a number from 0 to 1 for each yarn and cell (splitmix64: Steele, Lea and Flood 2014)."""
    mixed = np.asarray(yarn, dtype=np.uint64) * np.uint64(0xD1342543DE82EF95)
    mixed = mixed + np.asarray(cell, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    mixed = mixed + np.uint64(channel) * np.uint64(0xA0761D6478BD642F % 2**40)
    for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
        mixed = (mixed ^ (mixed >> np.uint64(shift))) * np.uint64(factor)
    mixed = mixed ^ (mixed >> np.uint64(31))
    return (mixed >> np.uint64(11)).astype(np.float64) / 2.0**53


def _bytes(linear: FloatArray) -> NDArray[np.uint8]:
    return np.round(255 * srgb_colour(np.clip(linear, 0.0, 1.0))).astype(np.uint8)


def _strands(
    lines: _Lines, points: FloatArray, out: FloatArray, radius: FloatArray, colour: NDArray[np.uint8], kind: int
) -> YarnStrands:
    yarn = lines.yarn[lines.start[:-1]]
    return YarnStrands(points, out, radius, colour, lines.start, lines.closed, lines.shift,
                       np.full(len(yarn), kind), yarn)  # fmt: skip
