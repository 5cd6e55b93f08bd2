# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Periodic yarn patterns of yarn-level cloth (Sperl et al. 2021) in ``.pyp`` files: text, in metres.

    *pattern    px py r n       periods along x and y, radius of all yarns, number of vertices and of edges
    *Q          x y z t         position of each vertex of the yarns' polylines, and its twist; z is the right side
    *E          v0 v1 di dj     edge from the vertex v0 to the image of the vertex v1 with the shift (di px, dj py)
    *RL         l               rest length of the edge that starts at each vertex, in the order of the vertices
    *RK         k1 k2           natural curvature at each vertex, 2 tan(angle / 2) with the angle between the edges of
                                the vertex at rest (Bergou et al. 2008)
    *RT         t               rest twist at each vertex
    *RefD1      x y z           director of the edge that starts at each vertex: a unit vector perpendicular to the
                                edge, to which twist and curvature refer

``#`` starts a comment, a line without numbers ends a block, and blocks with other names are ignored. The edges form
closed chains, the yarns; the sum of the shifts of a chain is the lattice step of the yarn. Vertices may lie in any
image of the cell.

A yarn becomes the spline through its vertices, with one segment for each edge. The segment has the rest length of the
edge. An arc is slightly longer than its chord, so that the stretched lengths of the spline exceed those of the polyline
by the same ratio.

The angle at a vertex divided by the length is the mean curvature about the vertex. For a spline with the curvatures c_i
at its knots, this mean is (c_(i-1) + 4 c_i + c_(i+1)) / 6, because the curvature is linear between the knots. The
natural curvature of a yarn therefore follows from the natural curvatures at the vertices by the same linear system by
which the control points follow from the positions. The natural curvatures of successive knots get the same sign if
their directions, perpendicular to the yarn, differ by less than a right angle. The directions and the twists themselves
are ignored, because a spline yarn rotates freely about its axis; the rest twist between successive directions is
ignored too.

The writer moves the vertices into the box from 0 to the periods and writes them in the order of the yarns, without
twist, and with their natural curvature as k1. In some published files the periods do not fit the yarns (the basket
weave of Sperl et al. states periods that are 1.5 % too small). The edges across the border are then not perpendicular
to their directors, and a warning is logged.
"""

from __future__ import annotations

import dataclasses
import logging
import math
from dataclasses import dataclass, field
from itertools import pairwise
from os import fspath

import numpy as np

from stitchmesh.errors import FileError, MeshError, first_few
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath, is_coordinate, read_lines
from stitchmesh.io.yarn_formats.splines import polyline_to_bspline
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet, basis

CENTIMETRES = 100.0
"""Centimetres in a metre."""
COLUMNS = {"pattern": 4, "Q": 4, "E": 4, "RL": 1, "RK": 2, "RefD1": 3}
"""Blocks that are read, and the number of numbers in each of their lines."""
OPTIONAL = ("RK", "RefD1")
"""Blocks that a file may lack; without ``RK`` the yarns are straight at rest."""

logger = logging.getLogger(__name__)


@dataclass
class _Block:
    """The numbers of a block and their line numbers, counted from 1."""

    line: int
    """Line number of the name of the block."""
    numbers: list[list[float]] = field(default_factory=list)
    """Numbers of each line."""
    lines: list[int] = field(default_factory=list)
    """Line number of each line."""


def read_pyp(path: FilePath) -> YarnSet:
    """Read the yarns of one cell.

    The yarns are in the order of their first vertices, and each yarn starts at its first vertex. A warning is logged if
    twists of vertices are ignored, or if the periods do not fit the yarns.

    Raises:
        FileError: the file cannot be read, lacks a block, has wrong counts or numbers, an edge to a vertex that does
            not exist, a vertex at which not exactly one edge starts and one ends, or a yarn of fewer than 3 vertices.
    """
    name = fspath(path)
    blocks = _blocks(name, read_lines(path))
    _check_sizes(name, blocks)
    for title, columns in (("pattern", slice(0, 3)), ("RL", slice(0, 1))):
        _check_positive(name, blocks[title], columns)
    vertices = np.array(blocks["Q"].numbers)
    if vertices[:, 3].any():
        logger.warning("%s: twists are ignored, because a spline yarn rotates freely about its axis", name)
    following, shift = _following(name, blocks["E"], len(vertices))
    chains = _chains(following)
    short = [chain for chain in chains if len(chain) < 3]  # A closed spline has at least three.
    if short:
        line, found = blocks["Q"].lines[short[0][0]], len(short[0])
        raise FileError(f"{name}: line {line}: the yarn of this vertex has {found} vertices; expected at least 3")
    width, height, radius, _ = blocks["pattern"].numbers[0]
    try:
        lattice = Lattice(CENTIMETRES * np.array([[width, 0.0, 0.0], [0.0, height, 0.0]]))
    except MeshError as error:
        raise FileError(f"{name}: periods of {width} and {height}: {error}") from error
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
    """Write the yarns of one cell; the vertices are the knots of the splines, and x and y are along the periods.

    Raises:
        FileError: the yarns are not periodic, have ends or several radii, have a natural curvature that turns an edge
            by half a turn or more, the periods are not perpendicular, or the file cannot be written.
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
    """Check that the format can hold yarns, and return their lattice and their lattice steps, shape (yarns, 2).

    Raises:
        FileError: as for ``write_pyp``.
    """
    name = fspath(path)
    if yarns.lattice is None or yarns.lattice_step is None:
        raise FileError(f"{name}: the yarns are not periodic; the format holds only periodic yarns, write .h5")
    if not yarns.closed.all():
        found = first_few(np.flatnonzero(~yarns.closed))
        raise FileError(f"{name}: yarn {found} has ends; the format holds only yarns without ends, write .h5")
    if np.ptp(yarns.radius) > 0.0:
        found = f"yarns of radius {yarns.radius.min():.4g} to {yarns.radius.max():.4g} cm"
        raise FileError(f"{name}: got {found}; the format holds one radius, write .h5")
    too_curved = np.flatnonzero(np.abs(_natural_angles(yarns)) >= math.pi)
    if len(too_curved):
        found = f"natural curvature turns the yarn by half a turn or more at knot {first_few(too_curved)}"
        raise FileError(f"{name}: {found}; the format holds smaller turns only, write .h5")
    cosine = float(np.dot(*_axes(yarns.lattice)[:2]))
    # Largest cosine between perpendicular periods, which rounding causes.
    if abs(cosine) > 1e-9:
        angle = math.degrees(math.acos(cosine))
        raise FileError(f"{name}: the periods are {angle:.4g} degrees apart; the format holds right angles, write .h5")
    return yarns.lattice, yarns.lattice_step


def _wrapped(yarns: YarnSet, lattice: Lattice, steps: IntArray, sides: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the knots in the box of the periods [m], shape (S, 3), and the edges between successive knots.

    Args:
        yarns: the yarns.
        lattice: their lattice.
        steps: lattice step of each yarn, shape (yarns, 2).
        sides: lengths of the periods [m], shape (2,).

    Returns:
        Knots, and edges as first knot, second knot and the shift to the image of the second knot, shape (S, 4).
    """
    knots = np.einsum("j,sjd->sd", basis(0.0)[0], yarns.corners_of()) @ _axes(lattice).T / CENTIMETRES
    image = np.floor(knots[:, :2] / sides).astype(np.int64)
    knots[:, :2] -= image * sides
    number = np.arange(len(knots))
    following, last = number + 1, yarns.segment_start[1:] - 1
    following[last] = yarns.segment_start[:-1]
    shift = image[following] - image
    shift[last] += steps
    return knots, np.column_stack([number, following, shift])


def _natural_angles(yarns: YarnSet) -> FloatArray:
    """Return the signed angle at rest between the edges that meet at the first knot of each segment, shape (S,)."""
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
    """Return the unit vectors along the periods and towards the right side of the fabric, as rows, shape (3, 3)."""
    u, v = lattice.periods / np.linalg.norm(lattice.periods, axis=1)[:, None]
    return np.stack([u, v, np.cross(u, v)])


def _blocks(name: str, lines: list[str]) -> dict[str, _Block]:
    """Return the blocks of a file by name."""
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
    """Return the numbers of a line; an empty list for a line of an ignored block, whose ``columns`` is None."""
    if columns is None:
        return []
    try:
        values = [float(word) for word in text]
    except ValueError as error:
        raise FileError(f"{name}: line {number}: got {' '.join(text)[:40]!r}; expected {columns} numbers") from error
    if len(values) != columns or not all(map(is_coordinate, values)):
        raise FileError(f"{name}: line {number}: got {' '.join(text)[:40]!r}; expected {columns} finite numbers")
    return values


def _check_sizes(name: str, blocks: dict[str, _Block]) -> None:
    """Check that every block has as many lines as the pattern states."""
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
    """Log a warning if edges are not perpendicular to their directors; both have the shape (n, 3)."""
    cosine = np.abs((edges * directors).sum(axis=1)) / np.linalg.norm(edges, axis=1)
    # Largest cosine between an edge and its director; published files have few digits.
    oblique = np.flatnonzero(cosine > 0.01 * np.linalg.norm(directors, axis=1))
    if len(oblique):
        found = f"the edge that starts at vertex {first_few(oblique)} is not perpendicular to its director"
        logger.warning("%s: %s; the periods may not be those of the yarns", name, found)


def _natural_curvatures(at_vertices: FloatArray, rest: FloatArray) -> FloatArray:
    """Return the natural curvatures at the control points of a yarn [1/cm], shape (n,).

    Args:
        at_vertices: natural curvatures k1 and k2 of the vertices, in the order of the chain, shape (n, 2).
        rest: rest lengths of the edges [cm], shape (n,).
    """
    size = np.hypot(*at_vertices.T)  # hypot is also correct for numbers whose squares overflow.
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
    """Return the vertex that follows each vertex, shape (n,), and the shift to its image, shape (n, 2).

    Args:
        name: the file, for error messages.
        block: the block of edges.
        count: number of vertices n.

    Raises:
        FileError: an edge is malformed, or not exactly one edge starts and one ends at each vertex.
    """
    edges = np.array(block.numbers)
    whole = (edges == np.round(edges)).all(axis=1) & (np.abs(edges) < 2**31).all(axis=1)
    known = (edges[:, :2] >= 0).all(axis=1) & (edges[:, :2] < count).all(axis=1)
    for index in np.flatnonzero(~(whole & known))[:1]:
        found = " ".join(f"{value:g}" for value in block.numbers[index])
        expected = f"vertices 0 to {count - 1} and a whole shift"
        raise FileError(f"{name}: line {block.lines[index]}: got edge {found}; expected {expected}")
    ends = edges.astype(np.int64)
    for side, verb in ((0, "start"), (1, "end")):
        uses = np.bincount(ends[:, side], minlength=count)
        # There are as many edges as vertices, so that a vertex without an edge implies another with two edges.
        for index in np.flatnonzero(uses[ends[:, side]] > 1)[-1:]:
            vertex = ends[index, side]
            found = f"{uses[vertex]} edges {verb} at vertex {vertex}"
            raise FileError(f"{name}: line {block.lines[index]}: {found}; expected one, so that chains are closed")
    following, shift = np.zeros(count, dtype=np.int64), np.zeros((count, 2), dtype=np.int64)
    following[ends[:, 0]], shift[ends[:, 0]] = ends[:, 1], ends[:, 2:]
    return following, shift


def _chains(following: IntArray) -> list[IntArray]:
    """Return the closed chains of vertices; each chain starts at its vertex with the smallest number.

    Every vertex is in exactly one chain, because one edge starts and one edge ends at each vertex.
    """
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
    """Return the control points of the spline through the vertices of a chain, in continuous coordinates.

    Args:
        vertices: vertices of the chain [cm], each in any image of the cell, shape (n, 3).
        shift: shift of each vertex to the image of the next vertex, shape (n, 2).
        lattice: the lattice.
    """
    step = lattice.shift(shift.sum(axis=0))
    image = np.concatenate([[[0, 0]], np.cumsum(shift[:-1], axis=0)])
    # The lattice step is subtracted as a linear function: the spline through points on a line is the line itself.
    trend = np.arange(len(vertices))[:, None] / len(vertices) * step
    ahead = step / len(vertices)
    return polyline_to_bspline(vertices + lattice.shift(image) - trend, closed=True) + trend - ahead
