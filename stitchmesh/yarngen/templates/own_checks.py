# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Checks of a stitch of the user's own; the built-in stitches pass the same checks.

Its yarn meets every side of its face where the neighbours expect it. Every loop passes through the loops below as its
letter says. Loops that are worked together lie in layers in the order of the code. Yarn of the row is not linked with
itself. Among knit and among purl stitches beside, above and below it, yarns keep their distances, however its loops are
twisted.

A drawing is tested on a small flat fabric of one stitch surrounded by plain stitches. The fabric has three rows: a row
of plain stitches, the stitch with one plain stitch on either side, and another row of plain stitches. All faces have
the proportions of their templates, so that the embedding does not deform the yarn.
"""

from __future__ import annotations

import itertools

import numpy as np

from stitchmesh.errors import YarnError
from stitchmesh.io.contents import FilePath
from stitchmesh.io.own_stitches import read_own_drawings
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.mesh.connectivity import find_twins
from stitchmesh.mesh.own_stitch import FIRST_OWN, OwnStitch, StitchType
from stitchmesh.mesh.stitch import VOCABULARY, Making, Stitch
from stitchmesh.yarngen.generate import generate_yarns
from stitchmesh.yarngen.templates.table import template_of_own
from stitchmesh.yarngen.templates.template import (
    RADIUS_OVER_WIDTH,
    STITCH_HEIGHT,
    Crossing,
    Template,
    TemplatePart,
    trapezoid,
    twisted,
)

PIERCING = {"k": 1, "p": -1, "y": 0}
"""How often the left leg of a loop passes through a loop below from behind to the front, by its letter."""
CLOSEST, CLOSEST_TWISTED = 1.0, 0.75
"""Smallest distance of yarns with untwisted and with twisted loops on top [radii]; touching yarns are 2 apart."""


def surround_stitch(
    stitch: StitchType, twists: tuple[int, ...] = (), plain: Stitch = Stitch.KNIT
) -> tuple[StitchMesh, int]:
    """A flat fabric of three rows around one stitch, and the number of the face of the stitch. Stitches are 1 cm wide.

    Args:
        stitch: a stitch of the vocabulary, or one of the user's own.
        twists: half turns of the loops on its top sides, from left to right.
        plain: type of the other stitches.
    """
    definition = stitch.making if isinstance(stitch, OwnStitch) else VOCABULARY[stitch]
    low, high = definition.n_bottom, definition.n_top
    lines = [_course(count, max(low, high)) for count in (low, low, high, high)]
    heights = STITCH_HEIGHT * np.arange(-1, 3)
    vertices = [(x, y, 0.0) for line, y in zip(lines, heights, strict=True) for x in line]
    first = np.cumsum([0, *(len(line) for line in lines)])
    faces = _quads(first[0], first[1], low + 2)
    centre = len(faces) + 1
    faces += _row_of(first[1], first[2], low, high)
    faces += _quads(first[2], first[3], high + 2)
    return _knitted(vertices, faces, centre, (low, high), stitch, plain, twists), centre


def _course(count: int, widest: int) -> np.ndarray:
    """The x of each vertex of a course line with ``count`` stitches and one more on either side, shape (count + 3,)."""
    return (widest - count) / 2 + np.arange(-1.0, count + 2)


def _quads(lower: int, upper: int, count: int) -> list[list[int]]:
    """Vertices of ``count`` neighbouring quads between two course lines, from their first vertices."""
    return [[lower + k, lower + k + 1, upper + k + 1, upper + k] for k in range(count)]


def _row_of(lower: int, upper: int, low: int, high: int) -> list[list[int]]:
    """Vertices of a row: a quad, a face with ``low`` bottom and ``high`` top sides, and a quad."""
    middle = [lower + 1 + k for k in range(low + 1)] + [upper + 1 + k for k in reversed(range(high + 1))]
    return [*_quads(lower, upper, 1), middle, *_quads(lower + low + 1, upper + high + 1, 1)]


def _knitted(
    vertices: list, faces: list[list[int]], centre: int, sides: tuple[int, int], stitch: StitchType, plain: Stitch,
    twists: tuple[int, ...],
) -> StitchMesh:  # fmt: skip
    """The stitch mesh of these faces."""
    face_start = np.concatenate([[0], np.cumsum([len(face) for face in faces])])
    face_vertex = np.concatenate(faces)
    kind, bottom, top, row = (np.full(len(faces), value) for value in (plain, 1, 1, 0))
    own = (stitch,) if isinstance(stitch, OwnStitch) else ()
    kind[centre], (bottom[centre], top[centre]) = FIRST_OWN if own else stitch, sides
    row[centre - 1 :], row[centre + 2 :] = 1, 2
    twist = np.zeros(len(face_vertex), dtype=np.int64)
    twist[face_start[centre] + sum(sides) - np.arange(len(twists))] = twists
    return StitchMesh(
        vertices=np.array(vertices), face_start=face_start, face_vertex=face_vertex,
        twin=find_twins(face_start, face_vertex, len(vertices)), n_bottom=bottom, n_top=top, stitch=kind, row=row,
        twist=twist, own_stitches=own,
    )  # fmt: skip


def read_own_stitches(path: FilePath) -> tuple[OwnStitch, ...]:
    """Read stitches of your own from a file of drawings, and check them as the built-in stitches are checked.

    Args:
        path: a JSON file (``docs/own-stitches.md``).

    Raises:
        FileError: the file cannot be read, or is no file of drawings.
        YarnError: the yarn of a drawing contradicts its code, or comes too close to other yarn.
    """
    stitches = read_own_drawings(path)
    for stitch in stitches:
        check_own_stitch(stitch)
    return stitches


def check_own_stitch(stitch: OwnStitch) -> None:
    """Check the drawing of a stitch of your own.

    Raises:
        YarnError: the yarn contradicts the code of the stitch, or comes too close to other yarn; the message names the
            parts by their numbers, from 1 in the order of the drawing.
    """
    making, where = stitch.making, f"stitch {stitch.code!r}"
    try:
        shape = template_of_own(stitch)
    except (YarnError, ValueError) as error:
        raise YarnError(f"{where}: {error}") from error
    _check_ends(where, shape)
    for twists in itertools.product((0, 1, -1), repeat=making.n_top):
        _check_passes(where, twisted(shape, twists), making)
    _check_layers(where, shape, making)
    _check_distances(stitch)


def _check_ends(where: str, shape: Template) -> None:
    """Check that every crossing of the face is the end of one part, and that the parts stay within the face."""
    ends = [(end.place, end.slot) for part in shape.parts for end in (part.start, part.end)]
    course = [place for place in range(shape.n_bottom + shape.n_top + 1) if place != shape.n_bottom]
    wales = [shape.n_bottom, shape.n_bottom + shape.n_top + 1]
    wanted = [(place, slot) for place in course for slot in (0, 1)] + [(place, 0) for place in wales]
    for end in wanted:
        if ends.count(end) != 1:
            found = f"{ends.count(end)} parts end at {_name_of(shape, Crossing(*end))}"
            raise YarnError(f"{where}: {found}; expected one, because the neighbour's yarn goes on there")
    for number, part in enumerate(shape.parts, start=1):
        is_loop_below = part.start.place == part.end.place < shape.n_bottom
        if part.is_head != is_loop_below:
            reason = "because it is a loop below" if is_loop_below else "because it is no loop below"
            expected = f"expected {str(is_loop_below).lower()}, {reason}"
            raise YarnError(f"{where}: part {number} has head {str(part.is_head).lower()}; {expected}")
        # Largest distance by which a spline may overshoot a side of its face [stitch widths]; a sixth of a radius.
        if _depth(shape, part.curve) < -0.02 or not np.isfinite(part.curve).all():
            found = f"part {number} leaves the face by {-_depth(shape, part.curve):.2f} stitch widths"
            raise YarnError(f"{where}: {found}; keep its points within the face")


def _depth(shape: Template, curve: FloatArray) -> float:
    """Return the smallest distance of a curve from the sides of its face, negative outside [stitch widths]."""
    corners = trapezoid(shape.n_bottom, shape.n_top)
    side = np.roll(corners, -1, axis=0) - corners
    inward = np.stack([-side[:, 1], side[:, 0]], axis=1) / np.linalg.norm(side, axis=1)[:, None]
    return float(np.einsum("kd,pkd->pk", inward, curve[:, None, :2] - corners[None]).min())


def _name_of(shape: Template, end: Crossing) -> str:
    low, high = shape.n_bottom, shape.n_top
    if end.place in (low, low + high + 1):
        return "right wale" if end.place == low else "left wale"
    if end.place < low:
        return f"bottom {end.place + 1} {'left' if end.slot == 0 else 'right'}"
    return f"top {low + high - end.place + 1} {'right' if end.slot == 0 else 'left'}"


def _check_passes(where: str, shape: Template, making: Making) -> None:
    """Check how often each part of the row passes through each loop below."""
    signs = [PIERCING[letter] for letter in making.made]
    heads = [(number, part) for number, part in enumerate(shape.parts, start=1) if part.is_head]
    for number, part in enumerate(shape.parts, start=1):
        if part.is_head:
            continue
        came, goes = (_loop_at(shape, end) for end in (part.start, part.end))
        wanted = (0 if goes is None else signs[goes]) - (0 if came is None else signs[came])
        for head_number, head in heads:
            sense = 1 if head.start.slot == 0 else -1
            found = sense * piercings(part, head)
            if found != wanted:
                passes = f"part {number} passes {found} times through the loop of part {head_number}, to the front"
                raise YarnError(f"{where}: {passes}; {making.made!r} of its code makes it {wanted}")


def _loop_at(shape: Template, end: Crossing) -> int | None:
    """Return the number of the loop on top to which a crossing belongs."""
    low, high = shape.n_bottom, shape.n_top
    return low + high - end.place if low < end.place <= low + high else None


def _check_layers(where: str, shape: Template, making: Making) -> None:
    """Check that loops worked together lie each in front of the next, and that yarn of the row is not linked."""
    parts = list(enumerate(shape.parts, start=1))
    heads = {part.start.place + 1: (number, part) for number, part in parts if part.is_head}
    for front, behind in itertools.combinations(making.order, 2):
        (one, first), (other, second) = heads[front], heads[behind]
        if set(crossings_between(first, second)[0]) - {1} or handedness(first, second):
            found = f"loop {front} below (part {one}) does not lie in front of loop {behind} (part {other}) throughout"
            raise YarnError(f"{where}: {found}; its code says that it does")
    own = [(number, part) for number, part in parts if not part.is_head]
    for (one, first), (other, second) in itertools.combinations(own, 2):
        if handedness(first, second):
            raise YarnError(f"{where}: parts {one} and {other} of its row are linked; expected them to be apart")


def _check_distances(stitch: OwnStitch) -> None:
    """Check the distances of yarns among plain stitches."""
    from stitchmesh.yarngen.clearance import smallest_distance

    for twists in itertools.product((0, 1, -1), repeat=stitch.making.n_top):
        for plain in (Stitch.KNIT, Stitch.PURL):
            fabric = surround_stitch(stitch, twists, plain)[0]
            try:
                yarns = generate_yarns(fabric, yarn_radius=RADIUS_OVER_WIDTH)
            except YarnError as error:
                raise YarnError(f"stitch {stitch.code!r}: among {plain.name} stitches: {error}") from error
            least = smallest_distance(yarns, 2 * RADIUS_OVER_WIDTH)[0] / RADIUS_OVER_WIDTH
            wanted = CLOSEST_TWISTED if any(twists) else CLOSEST
            if least <= wanted:
                found = f"yarns come as close as {least:.2f} radii among {plain.name} stitches, twists {twists}"
                remedy = "python assets/stitches/refine.py FILE moves them apart"
                raise YarnError(f"stitch {stitch.code!r}: {found}; expected more than {wanted:g}: {remedy}")


def crossings_between(first: TemplatePart, second: TemplatePart) -> tuple[list[int], list[int]]:
    """Return the crossings of two parts as seen from the right side.

    Returns:
        For each crossing along the first part 1 where it lies in front, else -1; and the handedness of each.
    """
    a, b = first.curve, second.curve
    u, v = np.diff(a[:, :2], axis=0)[:, None], np.diff(b[:, :2], axis=0)[None]
    gap = b[None, :-1, :2] - a[:-1, None, :2]
    det = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (gap[..., 0] * v[..., 1] - gap[..., 1] * v[..., 0]) / det
        t = (gap[..., 0] * u[..., 1] - gap[..., 1] * u[..., 0]) / det
    i, j = np.nonzero((s >= 0) & (s < 1) & (t >= 0) & (t < 1))
    s, t = s[i, j], t[i, j]
    ahead = a[i, 2] + s * (a[i + 1, 2] - a[i, 2]) - b[j, 2] - t * (b[j + 1, 2] - b[j, 2])
    front = np.sign(ahead).astype(int)
    return front.tolist(), (front * np.sign(det[i, j]).astype(int)).tolist()


def handedness(first: TemplatePart, second: TemplatePart) -> int:
    """Return the sum of the signs of the crossings of two parts; a motion without crossings of yarn preserves it."""
    return sum(crossings_between(first, second)[1])


def piercings(part: TemplatePart, head: TemplatePart) -> int:
    """Return how often a part passes through a head from behind to the front, minus how often it passes back.

    A head runs clockwise, upwards on its left side. A part in front of the head that leaves it over its edge therefore
    crosses it from right to left. A part that crosses behind the head does not pass through it there.
    """
    front, hand = crossings_between(part, head)
    return -sum(sign for ahead, sign in zip(front, hand, strict=True) if ahead > 0)
