# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Separate the yarn of drawn stitches: compute the table of drawings in the package from rough drawings.

    python assets/stitches/refine.py                 # all stitches of rough.json
    python assets/stitches/refine.py kpk d123k       # some stitches; all others do not change
    python assets/stitches/refine.py daisy.json      # stitches of your own; the file is written again

The method is a descent of an energy. Points along the drawn parts repel each other and the points of surrounding plain
stitches, knit and purl, for untwisted loops on top and for loops twisted in both directions. Parts resist bending and
stretching, and stay inside their face. No step moves a point by more than a fifth of the smallest distance between
points. Yarn therefore never passes through yarn, and a drawing keeps its topology for all twists.

All points depend linearly on the waypoints of the splines, so that a matrix converts the gradient of the energy with
respect to the points into the gradient with respect to the waypoints. Lengths are in yarn radii.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from stitchmesh.io.atomic import write_text
from stitchmesh.io.own_stitches import read_own_drawings
from stitchmesh.mesh.mean_value import mean_value_weights
from stitchmesh.mesh.own_stitch import StitchType
from stitchmesh.mesh.stitch import CODES, Stitch
from stitchmesh.yarngen.templates import table
from stitchmesh.yarngen.templates.own_checks import surround_stitch
from stitchmesh.yarngen.templates.table import PartDrawing, template, template_from_drawing, template_of_own
from stitchmesh.yarngen.templates.template import (
    HALF_GAP,
    LARGEST_SHARE_OF_PART,
    LONGEST_TURN,
    RADIUS_OVER_WIDTH,
    STITCH_HEIGHT,
    Crossing,
    Template,
    TemplatePart,
    centripetal_parameters,
    top,
    turn_angle,
)

Array = NDArray[np.float64]

ROUGH = Path(__file__).with_name("rough.json")
SHIPPED = Path(table.__file__).with_name("drawings.json")
RADII = np.array([1 / RADIUS_OVER_WIDTH, 1 / RADIUS_OVER_WIDTH, 1.0])
"""Conversion factors from the units of the points of a template to yarn radii."""
WAYPOINT_SPACING, POINT_SPACING = 1.7, 0.34
"""Distance of waypoints and of points along a part."""
REACH = 2.3
"""Distance below which yarns repel each other; the distance of yarns in contact is 2."""
ALONG = 3.6
"""Distance along a yarn below which two of its points do not repel each other."""
BENDING, LENGTH, INSIDE, FLATNESS = 0.5, 0.1, 3.0, 0.06
"""Weights of the energy terms relative to repulsion."""
TURNS = {0: 0.5, -1: 0.25, 1: 0.25}
"""Weight of the repulsion for each twist of the loops on top."""
MARGIN = 0.4
"""Distance that parts keep from the border of their face."""
FINE = 400
"""Number of points of a curve from which its arc length is computed."""
ROUNDS, STEPS = 15, 40
"""Number of rounds, and steps per round; waypoints and points are redistributed uniformly before each round."""
LARGEST_STEP = 0.2
"""Largest displacement of a point in one step, divided by the smallest distance."""
FIRST_PACE, LAST_PACE, MEMORY, SQUARE_MEMORY = 0.06, 0.004, 0.9, 0.98
"""Largest displacement of a waypoint in a step of the first and of the last round, and the decay rates of the running
means of the gradient and of its square."""
OUTWARD = np.array([2.0, 4.0, 0.0]) / 20**0.5
"""Direction in which the right leg of a plain loop crosses a course side upwards."""


@dataclass
class Strand:
    """A part of the drawing during the descent."""

    part: TemplatePart
    waypoints: Array
    """Waypoints of the spline, ends included, shape (w, 3)."""
    spline: CubicSpline
    """Spline of the weights of the waypoints."""
    arc: Array
    """Arc length at ``FINE`` uniform parameters of the spline."""
    place: int
    """Index of the first waypoint among the waypoints of all strands."""

    def weights(self, arcs: Array, total: int) -> Array:
        """Weights of all ``total`` waypoints for points at these arc lengths, shape (points, total)."""
        own = self.spline(np.interp(arcs, self.arc, np.linspace(0.0, self.spline.x[-1], FINE)))
        return np.pad(own, ((0, 0), (self.place, total - self.place - len(self.waypoints))))

    @property
    def even_arcs(self) -> Array:
        """Arc lengths of the points of the strand."""
        return np.linspace(0.0, self.arc[-1], round(self.arc[-1] / POINT_SPACING) + 1)


@dataclass
class Points:
    """Points that repel each other; the positions are ``weights @ waypoints + shift``."""

    weights: Array
    """Weights of the waypoints, shape (n, w); w is 0 for points that do not move."""
    shift: Array
    """Constant part of the positions, shape (n, 3)."""
    strand: NDArray[np.int64]
    """Strand of each point, shape (n,)."""
    arc: Array
    """Arc length from each point to both ends of its strand, shape (n, 2)."""
    ends: Array
    """Positions of these ends, shape (n, 2, 3)."""


def arc_lengths(points: Array) -> Array:
    """Arc length at each point of a polyline."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def strands_along(parts: list[TemplatePart], curves: list[Array]) -> list[Strand]:
    """Make strands along curves, with waypoints at uniform distances."""
    strands: list[Strand] = []
    for part, curve in zip(parts, curves, strict=True):
        arc = arc_lengths(curve)
        count = max(4, round(arc[-1] / WAYPOINT_SPACING) + 1)
        waypoints = CubicSpline(arc, curve)(np.linspace(0.0, arc[-1], count))
        places = centripetal_parameters(waypoints / RADII)
        spline = CubicSpline(places, np.eye(count), bc_type="natural")
        fine = arc_lengths(spline(np.linspace(0.0, places[-1], FINE)) @ waypoints)
        strands.append(Strand(part, waypoints, spline, fine, sum(len(each.waypoints) for each in strands)))
    return strands


@dataclass
class Line:
    """Points along one strand, before the points of all strands are concatenated."""

    weights: Array
    shift: Array
    ends: Array


def points_of(shape: Template, strands: list[Strand], turn: int) -> Points:
    """Points along all strands, with the loops on top twisted by ``turn`` half turns."""
    arcs = [strand.even_arcs for strand in strands]
    lines = [
        Line(strand.weights(arc, total_of(strands)), np.zeros((len(arc), 3)), strand.waypoints[[0, -1]])
        for strand, arc in zip(strands, arcs, strict=True)
    ]
    if turn:
        for loop in range(shape.n_top):
            slots = [top(shape.n_bottom, shape.n_top, loop, slot) for slot in (0, 1)]
            _turn(strands, lines, [_leg(strands, slot) for slot in slots], turn)
    number = np.repeat(np.arange(len(strands)), [len(arc) for arc in arcs])
    both = np.concatenate([np.stack([arc, arc[-1] - arc], axis=1) for arc in arcs])
    weights, shift = (np.concatenate([getattr(line, name) for line in lines]) for name in ("weights", "shift"))
    return Points(weights, shift, number, both, np.array([line.ends for line in lines])[number])


def total_of(strands: list[Strand]) -> int:
    """Number of waypoints of all strands."""
    return sum(len(strand.waypoints) for strand in strands)


def _leg(strands: list[Strand], slot: Crossing) -> tuple[int, int]:
    """The strand that ends at a crossing, and which of its ends this is: 0 (start) or 1 (end)."""
    number = next(k for k, each in enumerate(strands) if slot in (each.part.start, each.part.end))
    return number, int(strands[number].part.end == slot)


def _turn(strands: list[Strand], lines: list[Line], legs: list[tuple[int, int]], turn: int) -> None:
    """Twist the two legs of a loop about each other, as ``yarngen.templates.twists`` does."""
    length = min(LONGEST_TURN * RADII[0], *(LARGEST_SHARE_OF_PART * strands[number].arc[-1] for number, _ in legs))
    arrivals = [strands[number].waypoints[-end] for number, end in legs]
    for side, (number, end) in enumerate(legs):
        from_top = strands[number].even_arcs
        from_top = from_top[-1] - from_top if end else from_top
        turned = np.flatnonzero(from_top < length)
        from_top = from_top[turned]
        angle = turn_angle(1.0 - from_top / length)[:, None]
        other, other_end = strands[legs[1 - side][0]], legs[1 - side][1]
        across = other.weights(other.arc[-1] - from_top if other_end else from_top, total_of(strands))
        line = lines[number]
        line.weights[turned] = (line.weights[turned] * (1 + np.cos(angle)) + across * (1 - np.cos(angle))) / 2
        line.shift[turned] = turn * (1 - 2 * side) * HALF_GAP * np.sin(angle) * [0.0, 0.0, 1.0]
        line.ends[end] = arrivals[1 - side]


def around(shape: Template, stitch: StitchType, plain: Stitch) -> Points:
    """Points of the plain stitches around a stitch, in the coordinates of its template."""
    fabric, centre = surround_stitch(stitch, (), plain)
    beside = template(plain, 1, 1)
    points, arcs, ends = [], [], []
    for face in np.delete(np.arange(fabric.face_count), centre):
        corners = fabric.corner_position[fabric.face_start[face] : fabric.face_start[face + 1], :2]
        for part in beside.parts:
            curve = part.curve.copy()
            curve[:, :2] = mean_value_weights(beside.polygon, curve[:, :2]) @ corners
            arc = arc_lengths(curve * RADII)
            at = np.linspace(0.0, arc[-1], round(arc[-1] / POINT_SPACING))
            points.append(np.stack([np.interp(at, arc, axis) for axis in (curve * RADII).T], axis=1))
            arcs.append(np.stack([at, arc[-1] - at], axis=1))
            ends.append(np.broadcast_to(points[-1][[0, -1]], (len(at), 2, 3)))
    place = np.concatenate(points)
    near = depths(shape, place).min(axis=1) > -REACH - 0.5
    none = np.zeros((near.sum(), 0))
    return Points(none, place[near], np.full(near.sum(), -1), np.concatenate(arcs)[near], np.concatenate(ends)[near])


def inward_normals(shape: Template) -> Array:
    """Unit normals of the sides of a face, shape (sides, 2)."""
    side = np.roll(shape.polygon, -1, axis=0) - shape.polygon
    return np.stack([-side[:, 1], side[:, 0]], axis=1) / np.linalg.norm(side, axis=1)[:, None]


def depths(shape: Template, points: Array) -> Array:
    """Distance of points from each side of a face, positive inside, shape (n, sides)."""
    return np.einsum("kd,pkd->pk", inward_normals(shape), points[:, None, :2] - shape.polygon * RADII[:2])


def may_touch(points: Points, others: Points) -> NDArray[np.bool_]:
    """Whether two points belong to different yarns, or are far apart along one yarn, shape (n, m)."""
    same = (points.strand[:, None] == others.strand) & (points.strand[:, None] >= 0)
    near = same & (np.abs(points.arc[:, None, 0] - others.arc[None, :, 0]) < ALONG)
    for one in (0, 1):
        for other in (0, 1):
            along = points.arc[:, None, one] + others.arc[None, :, other] < ALONG
            gap = points.ends[:, None, one] - others.ends[None, :, other]
            near |= along & ~same & (np.abs(gap).max(axis=2) < 1e-6)
    return ~near


def repulsion(points: Array, others: Array, allowed: NDArray[np.bool_]) -> tuple[Array, float]:
    """Gradient of the sum of (REACH^2 / d^2 - 1)^2 over pairs with d < REACH, shape (n, 3), and the smallest d."""
    gap = points[:, None] - others[None]
    square = np.where(allowed, np.einsum("ijk,ijk->ij", gap, gap), np.inf)
    nearness = np.maximum(REACH**2 / square, 1.0)
    gradient = np.einsum("ij,ijk->ik", -4.0 * (nearness - 1.0) * nearness / square, gap)
    return gradient, float(square.min()) ** 0.5


def stiffness(shape: Template, strand: Strand, points: Array) -> Array:
    """Gradient of bending and length with respect to the points of a strand, shape (n, 3)."""
    step = np.linalg.norm(np.diff(points, axis=0), axis=1).mean()
    before = points[:1] + step * outward(shape, strand.part.start)
    after = points[-1:] + step * outward(shape, strand.part.end)
    bend = 2 * BENDING / step**3 * np.diff(np.concatenate([before, points, after]), 2, axis=0)
    gradient = np.zeros((len(points) + 2, 3))
    for shift, factor in ((0, 1.0), (1, -2.0), (2, 1.0)):
        gradient[shift : len(bend) + shift] += factor * bend
    tangent = LENGTH * np.diff(points, axis=0) / step
    gradient[1:-2] -= tangent
    gradient[2:-1] += tangent
    return gradient[1:-1]


def outward(shape: Template, crossing: Crossing) -> Array:
    """Direction in which the yarn of a plain stitch leaves a face through a crossing."""
    low, high = shape.n_bottom, shape.n_top
    if crossing.place in (low, low + high + 1):
        return np.array([1.0 if crossing.place == low else -1.0, 0.0, 0.0])
    is_top = crossing.place > low
    is_left = (crossing.slot == 0) != is_top
    upward = OUTWARD * [-1.0 if is_left else 1.0, 1.0, 1.0]
    return upward if is_top else -upward


def confinement(shape: Template, points: Array) -> Array:
    """Gradient of the terms that keep the points of a strand inside their face and near its plane, shape (n, 3)."""
    count = np.arange(len(points))
    margin = np.minimum(MARGIN, 0.5 * POINT_SPACING * np.minimum(count, count[::-1]))
    lacking = np.maximum(margin[:, None] - depths(shape, points), 0.0)
    inward = np.pad(inward_normals(shape), ((0, 0), (0, 1)))
    return -2 * INSIDE * lacking @ inward + 2 * FLATNESS * points * [0.0, 0.0, 1.0]


@dataclass
class Scene:
    """Strands, and the data of their energy during one round."""

    shape: Template
    strands: list[Strand]
    variants: list[tuple[float, Points, list[tuple[Points, NDArray[np.bool_]]]]]
    """For each twist: its weight, the points, and all points that repel them, with the pairs that may touch.

    The first of the repelling sets are the points themselves."""

    @property
    def waypoints(self) -> Array:
        """Waypoints of all strands, shape (w, 3)."""
        return np.concatenate([strand.waypoints for strand in self.strands])


def scene_of(shape: Template, strands: list[Strand], plain: list[Points]) -> Scene:
    """The scene of strands among plain stitches."""
    variants = []
    for turn, weight in TURNS.items():
        points = points_of(shape, strands, turn)
        variants.append((weight, points, [(other, may_touch(points, other)) for other in (points, *plain)]))
    return Scene(shape, strands, variants)


def gradient_and_nearest(scene: Scene) -> tuple[Array, float]:
    """Gradient of the energy with respect to the waypoints, shape (w, 3), and the smallest distance."""
    waypoints = scene.waypoints
    gradient, nearest = np.zeros_like(waypoints), np.inf
    for weight, points, others in scene.variants:
        where = points.weights @ waypoints + points.shift
        push = np.zeros_like(where)
        for number, (other, allowed) in enumerate(others):
            force, distance = repulsion(where, where if number == 0 else other.shift, allowed)
            push += force if number == 0 else force / (len(others) - 1)
            nearest = min(nearest, distance)
        gradient += weight * POINT_SPACING**2 * points.weights.T @ push
    for strand in scene.strands:
        weights = strand.weights(strand.even_arcs, len(waypoints))
        points = weights @ waypoints
        inside = POINT_SPACING * confinement(scene.shape, points)
        gradient += weights.T @ (stiffness(scene.shape, strand, points) + inside)
    for strand in scene.strands:
        gradient[[strand.place, strand.place + len(strand.waypoints) - 1]] = 0.0  # Ends, which join the neighbours.
    return gradient, nearest


def refine(code: str, parts: list[PartDrawing]) -> list[PartDrawing]:
    """Return the drawing of a built-in stitch with its yarn separated."""
    return separate(code, template_from_drawing(code, parts), CODES[code], parts)


def refine_own(path: Path) -> None:
    """Separate the yarn of the stitches of a file of drawings, and write the file again."""
    content = json.loads(path.read_text())
    for stitch in read_own_drawings(path):
        parts = content[stitch.code]["parts"]
        content[stitch.code]["parts"] = separate(stitch.code, template_of_own(stitch), stitch, parts)
    rows = []
    for code, drawing in content.items():
        head = [f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in drawing.items() if key != "parts"]
        parts = '  "parts": [\n   ' + ",\n   ".join(map(json.dumps, drawing["parts"])) + "\n  ]"
        rows.append(f" {json.dumps(code)}: {{\n" + ",\n".join([*head, parts]) + "\n }")
    write_text(path, "{\n" + ",\n".join(rows) + "\n}\n")


def separate(code: str, shape: Template, stitch: StitchType, parts: list[PartDrawing]) -> list[PartDrawing]:
    """Return the drawing of a stitch with its yarn separated.

    Args:
        code: name of the stitch in the output.
        shape: its template.
        stitch: the stitch.
        parts: its drawing.
    """
    plain = [around(shape, stitch, each) for each in (Stitch.KNIT, Stitch.PURL)]
    curves = [part.curve * RADII for part in shape.parts]
    for round_ in range(ROUNDS):
        scene = scene_of(shape, strands_along(list(shape.parts), curves), plain)
        nearest = descend(scene, FIRST_PACE * (LAST_PACE / FIRST_PACE) ** (round_ / ROUNDS))
        curves = [strand.weights(strand.even_arcs, len(scene.waypoints)) @ scene.waypoints for strand in scene.strands]
        if round_ % 5 == 0:
            print(f"{code}: smallest distance {nearest:.2f} radii")
    print(f"{code}: smallest distance {nearest:.2f} radii at the end")
    return [updated_part(part, strand) for part, strand in zip(parts, scene.strands, strict=True)]


def descend(scene: Scene, pace: float) -> float:
    """Descend the energy for ``STEPS`` steps (Adam with one step size).

    Return the smallest distance between points before the last step.

    Args:
        scene: strands, whose waypoints are changed.
        pace: largest displacement of a waypoint in one step, approximately.
    """
    mean, square = np.zeros_like(scene.waypoints), 0.0
    for step in range(1, STEPS + 1):
        gradient, nearest = gradient_and_nearest(scene)
        mean = MEMORY * mean + (1 - MEMORY) * gradient
        square = SQUARE_MEMORY * square + (1 - SQUARE_MEMORY) * (gradient**2).sum(axis=1).max()
        move = -pace * mean / ((square / (1 - SQUARE_MEMORY**step)) ** 0.5 + 1e-12)
        largest = max(np.linalg.norm(points.weights @ move, axis=1).max() for _, points, _ in scene.variants)
        move *= min(1.0, LARGEST_STEP * nearest / max(largest, 1e-12))
        for strand in scene.strands:
            strand.waypoints = strand.waypoints + move[strand.place : strand.place + len(strand.waypoints)]
    return nearest


def updated_part(part: PartDrawing, strand: Strand) -> PartDrawing:
    """Return the entry of the table for a strand."""
    inner = strand.waypoints[1:-1] / RADII / [1.0, STITCH_HEIGHT, 1.0]
    return {**part, "through": [tuple(point) for point in np.round(inner, 2).tolist()]}


def main() -> None:
    """Refine the drawings named on the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "codes", nargs="*", help="codes of the stitches, or files of drawings, to refine; all stitches by default"
    )
    given = parser.parse_args()
    files = [code for code in given.codes if code.endswith(".json")]
    for file in files:
        refine_own(Path(file))
    if files:
        return
    rough, shipped = json.loads(ROUGH.read_text()), json.loads(SHIPPED.read_text())
    for code in given.codes or rough:
        shipped[code] = refine(code, rough[code])
    rows = [f' "{code}": [\n  ' + ",\n  ".join(map(json.dumps, shipped[code])) + "\n ]" for code in rough]
    SHIPPED.write_text("{\n" + ",\n".join(rows) + "\n}\n")


if __name__ == "__main__":
    main()
