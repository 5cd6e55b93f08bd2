# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Places of close-ups: a face, faces, a row, a point, or a share of the picture of the whole object.

A close-up looks at a patch of the surface around the place, along the outward normal of the patch unless a view is
given. Outward is the side where the next surface is farther away, so that the patch is seen first.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import ParameterError, first_few
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.render.camera import VIEW_ANGLE, Camera, picture_axes

KINDS = {"face": 1, "row": 1, "point": 3, "share": 2}
"""How many numbers follow each word of a place."""
PATCH = 0.25
"""Radius of the patch that gives the direction of the close-up by its normal, over the width of the region."""
EXAMPLES = "face 120, row 12, point X Y Z in cm, or share U V from the lower left of the picture"


@dataclass(frozen=True)
class CloseUpTarget:
    """The place at which a close-up looks."""

    kind: str
    """A key of ``KINDS``, or ``faces``."""
    numbers: tuple[float, ...]
    """The numbers of the place."""


@dataclass(frozen=True)
class CloseUpPoints:
    """Points of an object with the faces and the rows to which they belong."""

    points: FloatArray
    """Positions [cm], shape (n, 3)."""
    face: IntArray
    """Face of each point, negative where there is none, shape (n,)."""
    row: IntArray
    """Row of each point, shape (n,)."""


def place_of(given: str | int | Iterable[int]) -> CloseUpTarget:
    """Return the place of a close-up.

    Args:
        given: a text (``face 120``, ``row 12``, ``point X Y Z`` [cm], or ``share U V``, the fractions of the width and
            the height of the picture of the whole object, from the lower left), a face, or several faces.

    Raises:
        ParameterError: the text is no place, or there are no faces.
    """
    if isinstance(given, str):
        return _parsed(given)
    faces = np.atleast_1d(np.asarray(list(given) if isinstance(given, Iterable) else given))
    if faces.size == 0 or faces.dtype.kind not in "iu":
        raise ParameterError(f"close-up: got {given!r}; expected {EXAMPLES}, or faces")
    return CloseUpTarget("faces", tuple(faces.tolist()))


def _parsed(text: str) -> CloseUpTarget:
    kind, *words = re.split(r"[\s,=]+", text.strip().lower())
    try:
        numbers = tuple(float(word) for word in words)
    except ValueError:
        numbers = ()
    whole = kind not in ("face", "row") or all(number.is_integer() for number in numbers)
    if len(numbers) != KINDS.get(kind, -1) or not whole or not np.isfinite(numbers).all():
        near = difflib.get_close_matches(kind, KINDS, n=1, cutoff=0.5)
        hint = f"; did you mean {near[0]!r}?" if near and near[0] != kind else ""
        raise ParameterError(f"close-up: got {text!r}; expected {EXAMPLES}{hint}")
    if kind == "share" and not all(0.0 <= number <= 1.0 for number in numbers):
        raise ParameterError(f"close-up: got {text!r}; expected shares of the picture from 0 to 1")
    return CloseUpTarget("faces" if kind == "face" else kind, numbers)


def close_up_patch(
    surface: CloseUpPoints, place: CloseUpTarget, whole: Camera, aspect: float, width: float
) -> tuple[int, IntArray]:
    """Find the point in the middle of a close-up, and the points of the patch around it.

    Args:
        surface: points of the object.
        place: the place.
        whole: the camera of the picture of the whole object.
        aspect: width of that picture over its height.
        width: width of the region of the close-up [cm].

    Returns:
        Number of the point in the middle, and the numbers of the points of the patch, shape (m,).

    Raises:
        ParameterError: a face or a row does not exist, or there is nothing at the share of the picture.
    """
    if place.kind == "point":
        middle = int(np.linalg.norm(surface.points - np.array(place.numbers), axis=1).argmin())
    elif place.kind == "share":
        middle = _at_share(surface.points, place.numbers, whole, aspect, width)
    else:
        middle = _foremost(surface.points, _members(surface, place), whole)
    near = np.linalg.norm(surface.points - surface.points[middle], axis=1) < PATCH * width
    return middle, np.flatnonzero(near)


def outward_normal(points: FloatArray, patch: IntArray, towards: FloatArray) -> FloatArray:
    """Return the outward unit normal of a patch of points, shape (3,).

    Args:
        points: all points of the object [cm], shape (n, 3).
        patch: the points of the patch, shape (m,).
        towards: the direction to take if the patch is alone, shape (3,).
    """
    centre = points[patch].mean(axis=0)
    if len(patch) < 3:
        return towards / np.linalg.norm(towards)
    normal = np.linalg.svd(points[patch] - centre, full_matrices=False)[2][2]
    size = float(np.linalg.norm(points[patch] - centre, axis=1).max())
    offset = points - centre
    depth = offset @ normal
    beside = np.linalg.norm(offset - depth[:, None] * normal, axis=1) < size
    above, below = (np.min(depth[beside & (depth > size)], initial=np.inf),
                    np.min(-depth[beside & (depth < -size)], initial=np.inf))  # fmt: skip
    if above == below:
        return normal if normal @ towards > 0 else -normal
    return normal if above > below else -normal


def _members(surface: CloseUpPoints, place: CloseUpTarget) -> IntArray:
    """Return the points of the faces or the row of a place."""
    wanted = np.array(place.numbers, dtype=np.int64)
    own, what = (surface.row, "row") if place.kind == "row" else (surface.face, "face")
    missing = wanted[~np.isin(wanted, own)]
    if len(missing):
        highest = int(own.max(initial=-1))
        known = f"the object has {what}s 0 to {highest}" if highest >= 0 else f"the object has no {what}s"
        raise ParameterError(f"close-up: there is no {what} {first_few(missing)}; {known}")
    return np.flatnonzero(np.isin(own, wanted))


def _foremost(points: FloatArray, members: IntArray, whole: Camera) -> int:
    """Return the member that is in the middle of the picture, among the half of the members nearer to the camera."""
    axes = picture_axes(whole.position - whole.focus, whole.up)
    place = points[members] @ axes
    front = np.flatnonzero(place[:, 2] >= (place[:, 2].min() + place[:, 2].max()) / 2)
    aside = np.linalg.norm(place[front, :2] - np.median(place[front, :2], axis=0), axis=1)
    return int(members[front[aside.argmin()]])


def _at_share(points: FloatArray, share: tuple[float, ...], whole: Camera, aspect: float, width: float) -> int:
    """Return the foremost point at a share of the picture of the whole object."""
    axes = picture_axes(whole.position - whole.focus, whole.up)
    offset = (points - whole.position) @ axes
    half = np.tan(np.radians(VIEW_ANGLE / 2)) * -offset[:, 2]
    place = np.stack([offset[:, 0] / (half * aspect), offset[:, 1] / half], axis=1)
    aside = np.linalg.norm((place - (2.0 * np.array(share) - 1.0)) * half[:, None] * [aspect, 1.0], axis=1)
    here = np.flatnonzero(aside < 0.1 * width)
    if not len(here):
        raise ParameterError(f"close-up: there is nothing at share {share[0]:g} {share[1]:g} of the picture")
    return int(here[(offset[here, 2] - aside[here]).argmax()])
