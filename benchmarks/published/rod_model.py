# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The discrete rod model of ``.pyp`` files, and the determination of its unknown constants from the files.

The energy divided by Young's modulus, for polylines of the radius r with edges e of the rest length l and vertices of
the mean rest length v (Bergou et al. 2008, 2010):

    stretch   pi r^2 / 2  sum (|e| / l - 1)^2 l
    bending   b pi r^4 / 8  sum |k - k'|^2 / v       k the curvature in the material frame, k' the natural one
    twist     b g pi r^4 / 4  sum (m - m')^2 / v     m the twist, m' the natural one
    contact   c  double integral of 1 / d^2 + d^2 - 2 over pairs of edges less than d = 1 diameter apart (Kaldor 2008)

The files contain all values except three numbers: g, the shear modulus divided by Young's modulus; b, the factor of the
bending and twist stiffness relative to a solid round rod; and the contact stiffness c. The yarns are relaxed, so that
the forces must cancel: the torques about the axes of the yarns give g alone, and the forces on the vertices b and c.

The periods are those for which the edges across the border are perpendicular to their directors; this does not hold for
the periods that the file of the basket weave states. All lengths are in metres.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

SAMPLES = 8
"""Number of contact samples of an edge."""
NEIGHBOURS = 3
"""Number of edges along a yarn within which two edges are not in contact."""
REACH = 1.25
"""Distance of listed pairs while yarns move [diameters]."""
IMAGES = ((0, 0), (0, 1), (1, -1), (1, 0), (1, 1))
"""Cells of the second edge of a pair; in the opposite cells the edge is the first of its pair."""
ROUNDS, STEPS = 15, 400
"""Numbers of rounds of a relaxation and of steps in a round; pairs and frames are updated in each round."""
MODULUS = 1e6
"""Assumed Young's modulus for forces [Pa]; relaxed states do not depend on it."""


class Slopes(NamedTuple):
    """An energy and its derivatives."""

    energy: float
    places: np.ndarray
    """Derivatives by the vertices, shape (n, 3)."""
    turns: np.ndarray
    """Derivatives by the rotations of the edges, shape (n,)."""
    periods: np.ndarray
    """Derivatives by the two periods for fixed vertices, shape (2,)."""


class Stiffness(NamedTuple):
    """Factors of the terms."""

    stretch: float
    bend: float
    twist: float
    contact: float


@dataclass(frozen=True, eq=False)
class Rods:
    """A cell of a file; an edge has the number of its first vertex."""

    places: np.ndarray
    turns: np.ndarray
    periods: np.ndarray
    radius: float
    following: np.ndarray
    """Vertex at the end of each edge."""
    before: np.ndarray
    """Edge that ends at each vertex."""
    shift: np.ndarray
    """Shift from the vertex in the cell to the end of each edge, in periods, shape (n, 2)."""
    rest_length: np.ndarray
    natural_curvature: np.ndarray
    natural_twist: np.ndarray
    tangents: np.ndarray
    """Tangents of the edges for which the file states the directors."""
    directors: np.ndarray
    reference_twist: np.ndarray

    @property
    def edges(self) -> np.ndarray:
        """Vector from each vertex to the next, shape (n, 3)."""
        return self.places[self.following] + self.shift * self.periods @ np.eye(2, 3) - self.places

    @property
    def vertex_length(self) -> np.ndarray:
        """Mean rest length of the edges on both sides of each vertex."""
        return (self.rest_length + self.rest_length[self.before]) / 2


@dataclass(frozen=True)
class Constants:
    """Constants from the balance of forces."""

    shear: float
    """Shear modulus over Young's modulus."""
    weakening: float
    """Factor of bending and twist."""
    contact: float
    """Contact stiffness over Young's modulus [m]."""
    turning_left: float
    """Remaining torques relative to those of bending."""
    force_left: float
    """Remaining forces relative to those of stretch."""

    def stiffness(self, radius: float) -> Stiffness:
        """Return the stiffnesses of stretch, bending, twist and contact of a rod of some radius [cm]."""
        bend = self.weakening * np.pi * radius**4 / 4
        return Stiffness(np.pi * radius**2, bend, 2 * self.shear * bend, self.contact)


def read_rods(path: Path) -> Rods:
    """Return the cell of a file with the periods that fit its yarns."""
    blocks = _blocks(path)
    ends = blocks["E"].astype(int)
    following, before = np.zeros(len(ends), dtype=int), np.zeros(len(ends), dtype=int)
    shift = np.zeros((len(ends), 2))
    following[ends[:, 0]], before[ends[:, 1]], shift[ends[:, 0]] = ends[:, 1], ends[:, 0], ends[:, 2:]
    places, directors = blocks["Q"][:, :3], blocks["RefD1"]
    across = shift.any(axis=1)
    inside = (directors * (places[following] - places)).sum(axis=1)
    periods = np.linalg.lstsq((directors[:, :2] * shift)[across], -inside[across], rcond=None)[0]
    rods = Rods(
        places, blocks["Q"][:, 3], periods, float(blocks["pattern"][0, 2]), following, before, shift,
        blocks["RL"][:, 0], blocks["RK"], blocks["RT"][:, 0], places, directors, blocks["RefT"][:, 0],
    )  # fmt: skip
    tangents = rods.edges / np.linalg.norm(rods.edges, axis=1)[:, None]
    directors = directors - _dot(directors, tangents)[:, None] * tangents
    return replace(rods, tangents=tangents, directors=directors / np.linalg.norm(directors, axis=1)[:, None])


def constants_of(rods: Rods) -> Constants:
    """Return the constants for which the forces in the cell of a file cancel."""
    size = np.pi * rods.radius**4 / 4
    stretch, bend, twist = (rod_slopes(rods, stiff) for stiff in np.diag([np.pi * rods.radius**2, size, 2 * size]))
    shear = -(bend.turns @ twist.turns) / (twist.turns @ twist.turns)
    left = np.linalg.norm(bend.turns + shear * twist.turns) / np.linalg.norm(bend.turns)
    touch = contact_slopes(rods, pairs_of(rods), 1.0)
    columns = np.stack([(bend.places + shear * twist.places).ravel(), touch.places.ravel()], axis=1)
    found = np.linalg.lstsq(columns, -stretch.places.ravel(), rcond=None)[0]
    force = np.linalg.norm(stretch.places.ravel() + columns @ found) / np.linalg.norm(stretch.places)
    return Constants(float(shear), float(found[0]), float(found[1]), float(left), float(force))


def tension(rods: Rods, stiff: Stiffness) -> np.ndarray:
    """Tensions along the two periods [dyn/cm]."""
    found = slopes(rods, pairs_of(rods), stiff)
    per_strain = (found.places * rods.places).sum(axis=0)[:2] + found.periods * rods.periods
    return MODULUS * per_strain / np.prod(rods.periods) * 1e3  # dyn/cm in N/m


def relaxed(rods: Rods, stiff: Stiffness) -> Rods:
    """Relax the rods and their periods by quasi-Newton steps."""
    count = len(rods.places)
    energy = np.pi * rods.radius**3 * 1e-6
    for _ in range(ROUNDS):
        base, pairs = transported(rods), pairs_of(rods)

        def at(unknowns: np.ndarray, base: Rods = base) -> tuple[Rods, np.ndarray]:
            factors = 1.0 + np.append(unknowns[-2:], 0.0)
            places = (base.places + base.radius * unknowns[: 3 * count].reshape(count, 3)) * factors
            turns = base.turns + unknowns[3 * count : -2]
            return replace(base, places=places, turns=turns, periods=base.periods * factors[:2]), factors

        def cost(unknowns: np.ndarray, base: Rods = base, pairs: Pairs = pairs) -> tuple[float, np.ndarray]:
            there, factors = at(unknowns, base)
            found = slopes(there, pairs, stiff)
            cell = (found.places * there.places / factors).sum(axis=0)[:2] + found.periods * base.periods
            by = np.concatenate([(found.places * factors * base.radius).ravel(), found.turns, cell])
            return found.energy / energy, by / energy

        options = {"maxiter": STEPS, "maxfun": 5 * STEPS, "maxcor": 30, "ftol": 1e-15, "gtol": 1e-12}
        rest = minimize(cost, np.zeros(4 * count + 2), jac=True, method="L-BFGS-B", options=options)
        rods = at(rest.x)[0]
    return transported(rods)


def slopes(rods: Rods, pairs: Pairs, stiff: Stiffness) -> Slopes:
    """Return the energy of all terms."""
    parts = rod_slopes(rods, np.array(stiff[:3])), contact_slopes(rods, pairs, stiff.contact)
    return Slopes(*(sum(each) for each in zip(*parts, strict=True)))  # type: ignore[arg-type]


def rod_slopes(rods: Rods, stiff: np.ndarray) -> Slopes:
    """Return the energy of stretch, bending and twist with the given factors (Bergou et al. 2010, appendix)."""
    edges, before = rods.edges, rods.before
    length = np.linalg.norm(edges, axis=1)
    frames = _frames(rods)
    t, m1, m2 = frames.tangents, frames.first, frames.second
    into, chi = t[before], 1.0 + _dot(t[before], t)
    binormal = 2 * np.cross(into, t) / chi[:, None]
    bent1, bent2 = _dot(binormal, m2 + m2[before]) / 2, -_dot(binormal, m1 + m1[before]) / 2
    twist = rods.turns - rods.turns[before] + frames.reference_twist
    strain = length / rods.rest_length - 1.0
    off = np.stack([bent1, bent2], axis=1) - rods.natural_curvature
    off_twist = twist - rods.natural_twist
    energy = stiff[0] * (strain**2 * rods.rest_length).sum()
    energy += ((stiff[1] * (off**2).sum(axis=1) + stiff[2] * off_twist**2) / rods.vertex_length).sum()
    pull1, pull2 = (stiff[1] * off / rods.vertex_length[:, None]).T[..., None]
    torque = stiff[2] * off_twist / rods.vertex_length
    mean = (into + t) / chi[:, None]
    mean1, mean2 = (m1[before] + m1) / chi[:, None], (m2[before] + m2) / chi[:, None]
    along = pull1 * bent1[:, None] * mean + pull2 * bent2[:, None] * mean
    half = (torque / 2)[:, None] * binormal
    by_in = (np.cross(t, pull1 * mean2 - pull2 * mean1) - along + half) / length[before][:, None]
    by_edge = (np.cross(into, pull2 * mean1 - pull1 * mean2) - along + half) / length[:, None]
    by_edge += (stiff[0] * strain)[:, None] * t
    np.add.at(by_edge, before, by_in)
    spin = [-(pull1[:, 0] * _dot(binormal, a) + pull2[:, 0] * _dot(binormal, b)) / 2
            for a, b in ((m1, m2), (m1[before], m2[before]))]  # fmt: skip
    by_turn = spin[0] + torque
    np.add.at(by_turn, before, spin[1] - torque)
    by_place = -by_edge
    np.add.at(by_place, rods.following, by_edge)
    return Slopes(float(energy) / 2, by_place, by_turn, (rods.shift * by_edge[:, :2]).sum(axis=0))


class Pairs(NamedTuple):
    """Samples of edges that may touch, and the shift from the cell of the first to that of the second, in periods."""

    first: np.ndarray
    second: np.ndarray
    image: np.ndarray


def pairs_of(rods: Rods) -> Pairs:
    """Return all pairs of near samples, each pair once, without the pairs of adjacent edges of a yarn."""
    samples = _samples(rods)
    found = []
    for image in IMAGES:
        apart = samples[:, None] - samples[None] - np.append(rods.periods * image, 0.0)
        near = np.linalg.norm(apart, axis=2) < REACH * 2 * rods.radius
        near &= np.repeat(np.repeat(~_neighbours(rods, image), SAMPLES, axis=0), SAMPLES, axis=1)
        first, second = np.nonzero(np.triu(near, 1) if image == (0, 0) else near)
        found.append((first, second, np.broadcast_to(image, (len(first), 2))))
    return Pairs(*(np.concatenate(part) for part in zip(*found, strict=True)))


def contact_slopes(rods: Rods, pairs: Pairs, stiff: float) -> Slopes:
    """Return the energy of contact."""
    samples, count = _samples(rods), len(rods.places)
    apart = samples[pairs.first] - samples[pairs.second]
    apart[:, :2] -= pairs.image * rods.periods
    distance = np.linalg.norm(apart, axis=1)
    d = np.minimum(distance / (2 * rods.radius), 1.0)
    weight = np.repeat(rods.rest_length, SAMPLES) / SAMPLES
    weight = stiff * weight[pairs.first] * weight[pairs.second]
    push = (weight * (2 * d - 2 / d**3) / (2 * rods.radius * distance))[:, None] * apart
    on = np.zeros_like(samples)
    np.add.at(on, pairs.first, push)
    np.add.at(on, pairs.second, -push)
    share = (np.arange(SAMPLES) + 0.5) / SAMPLES
    on = on.reshape(count, SAMPLES, 3)
    start, end = np.einsum("k,ikc->ic", 1 - share, on), np.einsum("k,ikc->ic", share, on)
    by_place = start.copy()
    np.add.at(by_place, rods.following, end)
    by_period = (rods.shift * end[:, :2]).sum(axis=0) - (pairs.image * push[:, :2]).sum(axis=0)
    return Slopes(float((weight * (1 / d**2 + d**2 - 2)).sum()), by_place, np.zeros(count), by_period)


def _samples(rods: Rods) -> np.ndarray:
    share = (np.arange(SAMPLES) + 0.5) / SAMPLES
    return (rods.places[:, None] + share[None, :, None] * rods.edges[:, None]).reshape(-1, 3)


def _neighbours(rods: Rods, image: tuple[int, int]) -> np.ndarray:
    """Return whether an edge and an image of another edge are adjacent along a yarn, shape (n, n)."""
    count = len(rods.places)
    found = np.zeros((count, count), dtype=bool)
    ahead, way = np.arange(count), np.zeros((count, 2))
    for _ in range(NEIGHBOURS + 1):
        there, back = (way == image).all(axis=1), (way == -np.array(image)).all(axis=1)
        found[np.flatnonzero(there), ahead[there]] = True
        found[ahead[back], np.flatnonzero(back)] = True
        way, ahead = way + rods.shift[ahead], rods.following[ahead]
    return found


class Frames(NamedTuple):
    """Return tangents, directors and material directors of the edges, and the twist of the directors at each vertex."""

    tangents: np.ndarray
    directors: np.ndarray
    first: np.ndarray
    second: np.ndarray
    reference_twist: np.ndarray


def _frames(rods: Rods) -> Frames:
    """Return the directors after parallel transport in time (Bergou et al. 2010, section 4)."""
    t = rods.edges / np.linalg.norm(rods.edges, axis=1)[:, None]
    first = _carried(rods.directors, rods.tangents, t)
    second = np.cross(t, first)
    cosine, sine = np.cos(rods.turns)[:, None], np.sin(rods.turns)[:, None]
    from_before = _carried(first[rods.before], t[rods.before], t)
    turned = from_before * np.cos(rods.reference_twist)[:, None]
    turned += np.cross(t, from_before) * np.sin(rods.reference_twist)[:, None]
    more = np.arctan2(_dot(np.cross(turned, first), t), _dot(turned, first))
    material = cosine * first + sine * second, cosine * second - sine * first
    return Frames(t, first, *material, rods.reference_twist + more)


def transported(rods: Rods) -> Rods:
    """Return the same rods with the present directors and reference twists."""
    frames = _frames(rods)
    return replace(rods, tangents=frames.tangents, directors=frames.directors, reference_twist=frames.reference_twist)


def _carried(vectors: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Rotate vectors by the smallest rotations from some unit vectors to others."""
    axis, cosine = np.cross(start, end), _dot(start, end)[:, None]
    return vectors * cosine + np.cross(axis, vectors) + axis * (_dot(axis, vectors)[:, None] / (1 + cosine))


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (a * b).sum(axis=1)


def _blocks(path: Path) -> dict[str, np.ndarray]:
    """Return the numbers of each block of a file."""
    found: dict[str, list[list[float]]] = {}
    name = ""
    for line in path.read_text().splitlines():
        words = line.partition("#")[0].split()
        if words and words[0].startswith("*"):
            name = words[0][1:]
            found[name] = []
        elif words:
            found[name].append([float(word) for word in words])
    return {name: np.array(rows) for name, rows in found.items()}
