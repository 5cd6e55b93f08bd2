# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""``.pyp``, periodic yarn patterns of yarn-level cloth (Sperl et al. 2021): text, in metres.

    *pattern    px py r n       periods along x and y, radius of all yarns, number of vertices and of edges
    *Q          x y z t         each vertex of the yarns' polylines and its twist; z is the right side
    *E          v0 v1 di dj     each edge goes from v0 to the image of v1 that is (di px, dj py) away
    *RL         l               rest length of the edge that leaves each vertex, in the order of the vertices
    *RK         natural curvature k1 k2 at each vertex, 2 tan of half the angle of its edges at rest (Bergou 2008)
    *RT         rest twist, in the same order
    *RefD1      a unit vector across the edge that leaves each vertex, to which twist and curvature refer

``#`` begins a comment, a line without numbers ends a block, blocks of other names are passed over. The edges form
closed chains, the yarns; their shifts add up to the lattice step. Vertices may lie in any image of the cell.

A yarn is the spline through its vertices, one segment to an edge, and the segment takes the edge's rest length: an
arc is a little longer than its chord, so that strains are higher than those of the polyline by that much.

Angle over length is the mean curvature (c_(i-1) + 4 c_i + c_(i+1)) / 6 about a vertex of a spline with curvatures c at
its knots, since between them these are linear. So the natural curvature of a yarn comes from that of the vertices by
the same solution as its control points from their places. Two that lie within a right angle of each other, across the
yarn, get one sign. Directions and twists are dropped, a spline yarn turns about its axis as it likes; of neighbours'
directions the rest twist between them is left out.

Vertices are written into the box from 0 to the periods, in the order of the yarns, with no twist, and their natural
curvature as k1. Files exist whose periods are not those of their yarns (that group's basket weave states them 1.5 %
smaller): edges across the border are then not square to their directors, and a warning says so.
"""

from __future__ import annotations

import dataclasses
import logging
import math
from dataclasses import dataclass, field
from itertools import pairwise
from os import fspath

import numpy as np

from stitchmesh.errors import FileError, first_few
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath, read_lines
from stitchmesh.io.yarn_formats.splines import polyline_to_bspline
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet, basis

CENTIMETRES = 100.0
"""In a metre."""
COLUMNS = {"pattern": 4, "Q": 4, "E": 4, "RL": 1, "RK": 2, "RefD1": 3}
"""Numbers to a line in the blocks that are read."""
OPTIONAL = ("RK", "RefD1")
"""Those that a file may lack; without ``RK`` yarns are straight at rest."""
FARTHEST = 2**31
"""Vertices and shifts of edges stay below."""
FEWEST_VERTICES = 3
"""Of a closed spline."""
UPRIGHT = 0.01
"""Largest cosine between an edge and its director that is square to it but for the digits of a file."""
RIGHT_ANGLE = 1e-9
"""Largest cosine between periods that are at right angles but for rounding."""

logger = logging.getLogger(__name__)


@dataclass
class _Block:
    """The numbers of a block and the lines that they stand in."""

    line: int
    """Where its name stands."""
    numbers: list[list[float]] = field(default_factory=list)
    """The numbers of each line."""
    lines: list[int] = field(default_factory=list)
    """Where they stand."""


def read_pyp(path: FilePath) -> YarnSet:
    """A cell of yarns; they are in the order of their first vertices and begin there.

    A warning says where twists of vertices were dropped, and where the periods do not fit the yarns.

    Raises:
        FileError: the file cannot be read, lacks a block, has wrong counts or numbers, an edge to a vertex that does
            not exist, a vertex that not exactly one edge leaves and one reaches, or a yarn of fewer than 3 vertices.
    """
    name = fspath(path)
    blocks = _blocks(name, read_lines(path))
    _check_sizes(name, blocks)
    for title, columns in (("pattern", slice(0, 3)), ("RL", slice(0, 1))):
        _check_positive(name, blocks[title], columns)
    vertices = np.array(blocks["Q"].numbers)
    if vertices[:, 3].any():
        logger.warning("%s: twists are dropped, a spline yarn turns about its own axis as it likes", name)
    following, shift = _following(name, blocks["E"], len(vertices))
    chains = _chains(following)
    short = [chain for chain in chains if len(chain) < FEWEST_VERTICES]
    if short:
        line, found = blocks["Q"].lines[short[0][0]], len(short[0])
        raise FileError(f"{name}: line {line}: the yarn of this vertex has {found} vertices; expected at least 3")
    width, height, radius, _ = blocks["pattern"].numbers[0]
    lattice = Lattice(CENTIMETRES * np.array([[width, 0.0, 0.0], [0.0, height, 0.0]]))
    if "RefD1" in blocks:
        edges = CENTIMETRES * (vertices[following] - vertices)[:, :3] + lattice.shift(shift)
        _check_directors(name, edges, np.array(blocks["RefD1"].numbers))
    rest_length = CENTIMETRES * np.array(blocks["RL"].numbers)[:, 0]
    natural = np.array(blocks["RK"].numbers) if "RK" in blocks else np.zeros((len(vertices), 2))
    curves = [_control_points(CENTIMETRES * vertices[chain, :3], shift[chain], lattice) for chain in chains]
    bare = YarnSet.from_curves(
        curves,
        closed=[True] * len(chains),
        radius=CENTIMETRES * radius,
        rest_lengths=[rest_length[chain] for chain in chains],
    )
    curvatures = np.concatenate([_natural_curvatures(natural[chain], rest_length[chain]) for chain in chains])
    steps = np.stack([shift[chain].sum(axis=0) for chain in chains])
    return dataclasses.replace(bare, natural_curvature=curvatures, lattice=lattice, lattice_step=steps)


def write_pyp(path: FilePath, yarns: YarnSet) -> None:
    """Write a cell: its vertices are the spline at its knots, x and y run along the periods.

    Raises:
        FileError: the yarns do not repeat, end, are of several radii, are so curved at rest that an edge turns half
            round, their periods are not at right angles, or the file cannot be written.
    """
    lattice, steps = check_pyp(path, yarns)
    sides = np.linalg.norm(lattice.periods, axis=1) / CENTIMETRES
    knots, edges = _wrapped(yarns, lattice, steps, sides)
    blocks = {
        "pattern # px py radius num_vertedges": [[*sides.tolist(), float(yarns.radius[0]) / CENTIMETRES, len(knots)]],
        "Q # dofs: x y z t": [[*knot, 0.0] for knot in knots.tolist()],
        "E # edges [v0, v1, dx, dy]": edges.tolist(),
        "RL # rest lengths": (yarns.rest_length[:, None] / CENTIMETRES).tolist(),
        "RK # rest kappas": [[2.0 * math.tan(angle / 2), 0.0] for angle in _natural_angles(yarns).tolist()],
        "RT # rest twists": [[0.0]] * len(knots),
    }
    text = [f"*{title}\n" + "\n".join(map(_line, rows)) + "\n" for title, rows in blocks.items()]
    write_text(path, "\n".join(text))


def check_pyp(path: FilePath, yarns: YarnSet) -> tuple[Lattice, IntArray]:
    """Lattice and steps of yarns that the format can hold.

    Raises:
        FileError: as for ``write_pyp``.
    """
    name = fspath(path)
    if yarns.lattice is None or yarns.lattice_step is None:
        raise FileError(f"{name}: the format holds yarns that repeat and these do not; write .h5")
    if not yarns.closed.all():
        found = first_few(np.flatnonzero(~yarns.closed))
        raise FileError(f"{name}: yarn {found} ends; the format holds only yarns that go on, write .h5")
    if np.ptp(yarns.radius) > 0.0:
        found = f"yarns of radius {yarns.radius.min():.4g} to {yarns.radius.max():.4g} cm"
        raise FileError(f"{name}: got {found}; the format holds one radius, write .h5")
    round_about = np.flatnonzero(np.abs(_natural_angles(yarns)) >= math.pi)
    if len(round_about):
        found = f"natural curvature turns the yarn by half a turn or more at knot {first_few(round_about)}"
        raise FileError(f"{name}: {found}; the format holds less, write .h5")
    cosine = float(np.dot(*_axes(yarns.lattice)[:2]))
    if abs(cosine) > RIGHT_ANGLE:
        angle = math.degrees(math.acos(cosine))
        raise FileError(f"{name}: the periods are {angle:.4g} degrees apart; the format holds right angles, write .h5")
    return yarns.lattice, yarns.lattice_step


def _wrapped(yarns: YarnSet, lattice: Lattice, steps: IntArray, sides: FloatArray) -> tuple[FloatArray, IntArray]:
    """Knots [m] in the box of the periods, shape (S, 3), and the edges from each to the next, shape (S, 4)."""
    corners = yarns.points[yarns.segment_points]
    corners = corners if yarns.point_shift is None else corners + yarns.point_shift
    knots = np.einsum("j,sjd->sd", basis(0.0)[0], corners) @ _axes(lattice).T / CENTIMETRES
    image = np.floor(knots[:, :2] / sides).astype(np.int64)
    knots[:, :2] -= image * sides
    number = np.arange(len(knots))
    following, last = number + 1, yarns.segment_start[1:] - 1
    following[last] = yarns.segment_start[:-1]
    shift = image[following] - image
    shift[last] += steps
    return knots, np.column_stack([number, following, shift])


def _natural_angles(yarns: YarnSet) -> FloatArray:
    """Angle at rest between the edges that meet at the first knot of each segment, signed, shape (S,)."""
    angles = []
    for first, last in pairwise(yarns.segment_start.tolist()):
        length = yarns.rest_length[first:last]
        knots = yarns.natural_ends[first:last, 0]
        mean = (np.roll(knots, 1) + 4 * knots + np.roll(knots, -1)) / 6
        angles.append(mean * (length + np.roll(length, 1)) / 2)
    return np.concatenate(angles)


def _line(numbers: list[float]) -> str:
    return " ".join(map(repr, numbers))


def _axes(lattice: Lattice) -> FloatArray:
    """Unit vectors along the periods and to the right side of the fabric, shape (3, 3)."""
    u, v = lattice.periods / np.linalg.norm(lattice.periods, axis=1)[:, None]
    return np.stack([u, v, np.cross(u, v)])


def _blocks(name: str, lines: list[str]) -> dict[str, _Block]:
    blocks: dict[str, _Block] = {}
    block = None
    for number, line in enumerate(lines, start=1):
        text = line.partition("#")[0].split()
        if text and text[0].startswith("*"):
            block = _Block(number)
            if text[0][1:] in blocks:
                raise FileError(f"{name}: line {number}: a second block {text[0]}; expected one")
            blocks[text[0][1:]] = block
            columns = COLUMNS.get(text[0][1:])
        elif text and block is None:
            raise FileError(f"{name}: line {number}: got {text[0][:20]!r} outside of any block; expected '*pattern'")
        elif text and block is not None:
            block.numbers.append(_numbers(name, number, text, columns))
            block.lines.append(number)
        else:
            block = None
    missing = [title for title in COLUMNS if title not in OPTIONAL and not blocks.get(title, _Block(0)).numbers]
    if missing:
        raise FileError(f"{name}: block *{missing[0]} is missing or empty; expected a periodic yarn pattern")
    return blocks


def _numbers(name: str, number: int, text: list[str], columns: int | None) -> list[float]:
    """The numbers of a line; none in blocks that are passed over."""
    if columns is None:
        return []
    try:
        values = [float(word) for word in text]
    except ValueError as error:
        raise FileError(f"{name}: line {number}: got {' '.join(text)[:40]!r}; expected {columns} numbers") from error
    if len(values) != columns or not all(map(math.isfinite, values)):
        raise FileError(f"{name}: line {number}: got {' '.join(text)[:40]!r}; expected {columns} finite numbers")
    return values


def _check_sizes(name: str, blocks: dict[str, _Block]) -> None:
    line = blocks["pattern"].lines[0]
    if len(blocks["pattern"].lines) > 1:
        raise FileError(f"{name}: line {line + 1}: a second line of *pattern; expected one")
    count = blocks["pattern"].numbers[0][3]
    for title, block in blocks.items():
        if title not in COLUMNS or title == "pattern":
            continue
        if len(block.lines) != count:
            found = f"block *{title} has {len(block.lines)} lines and line {line} says {count:g}"
            raise FileError(f"{name}: line {block.line}: {found}; it was cut short or altered")


def _check_positive(name: str, block: _Block, columns: slice) -> None:
    for line, numbers in zip(block.lines, block.numbers, strict=True):
        if min(numbers[columns]) <= 0.0:
            raise FileError(f"{name}: line {line}: got {min(numbers[columns]):g}; expected positive lengths in metres")


def _check_directors(name: str, edges: FloatArray, directors: FloatArray) -> None:
    """Warn where edges are not square to their directors."""
    cosine = np.abs((edges * directors).sum(axis=1)) / np.linalg.norm(edges, axis=1)
    leaning = np.flatnonzero(cosine > UPRIGHT * np.linalg.norm(directors, axis=1))
    if len(leaning):
        found = f"the edge that leaves vertex {first_few(leaning)} is not square to its director"
        logger.warning("%s: %s; the periods may not be those of the yarns", name, found)


def _natural_curvatures(at_vertices: FloatArray, rest: FloatArray) -> FloatArray:
    """Natural curvature [1/cm] of a yarn's control points, from that of its vertices in chain order, shape (n,)."""
    size = np.hypot(*at_vertices.T)  # of numbers whose squares overflow, too
    curvature = 2 * np.arctan(size / 2) / ((rest + np.roll(rest, 1)) / 2)
    vectors = at_vertices * (curvature / np.where(size > 0.0, size, 1.0))[:, None]
    knots = polyline_to_bspline(vectors, closed=True)
    found = np.linalg.norm(knots, axis=1)
    bent = np.flatnonzero(found > 0.0)
    if len(bent):
        turns = (knots[bent[1:]] * knots[bent[:-1]]).sum(axis=1) < 0.0
        sides = np.cumprod(np.concatenate([[1 if knots[bent[0], 0] >= 0.0 else -1], np.where(turns, -1, 1)]))
        found[bent] *= sides
    return found


def _following(name: str, block: _Block, count: int) -> tuple[IntArray, IntArray]:
    """Vertex that follows each vertex, and the shift to its image, shapes (n,) and (n, 2)."""
    edges = np.array(block.numbers)
    whole = (edges == np.round(edges)).all(axis=1) & (np.abs(edges) < FARTHEST).all(axis=1)
    known = (edges[:, :2] >= 0).all(axis=1) & (edges[:, :2] < count).all(axis=1)
    for index in np.flatnonzero(~(whole & known))[:1]:
        found = " ".join(f"{value:g}" for value in block.numbers[index])
        expected = f"vertices 0 to {count - 1} and a whole shift"
        raise FileError(f"{name}: line {block.lines[index]}: got edge {found}; expected {expected}")
    ends = edges.astype(np.int64)
    for side, verb in ((0, "leave"), (1, "reach")):
        uses = np.bincount(ends[:, side], minlength=count)
        for index in np.flatnonzero(uses[ends[:, side]] > 1)[-1:]:  # so many edges as vertices: one is left out too
            vertex = ends[index, side]
            found = f"{uses[vertex]} edges {verb} vertex {vertex}"
            raise FileError(f"{name}: line {block.lines[index]}: {found}; expected one, so that chains close")
    following, shift = np.zeros(count, dtype=np.int64), np.zeros((count, 2), dtype=np.int64)
    following[ends[:, 0]], shift[ends[:, 0]] = ends[:, 1], ends[:, 2:]
    return following, shift


def _chains(following: IntArray) -> list[IntArray]:
    """The closed chains of vertices, each from its first; every vertex is in one, as one edge leaves and reaches it."""
    chains: list[IntArray] = []
    seen = np.zeros(len(following), dtype=bool)
    for first in range(len(following)):
        chain = []
        vertex = first
        while not seen[vertex]:
            seen[vertex] = True
            chain.append(vertex)
            vertex = int(following[vertex])
        if chain:
            chains.append(np.array(chain))
    return chains


def _control_points(vertices: FloatArray, shift: IntArray, lattice: Lattice) -> FloatArray:
    """Control points of the spline through a chain's vertices, unwrapped; shifts lead from each to the next."""
    step = lattice.shift(shift.sum(axis=0))
    image = np.concatenate([[[0, 0]], np.cumsum(shift[:-1], axis=0)])
    trend = np.arange(len(vertices))[:, None] / len(vertices) * step  # a spline through points on a line is the line
    ahead = step / len(vertices)
    return polyline_to_bspline(vertices + lattice.shift(image) - trend, closed=True) + trend - ahead
