# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Triangles chosen by hand: in a box in space, in a rectangle of a panel, by their numbers, by faces of a stitch mesh.

All functions return numbers of triangles, ascending and without repeats, as a region takes them
(``region_around``). A triangle belongs to a box or a rectangle if its centre does.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import StitchMesh
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.cloth.from_stitches import triangle_start

Integers = NDArray[np.int64]
Numbers = NDArray[np.float64]


def triangles_in_box(cloth: Cloth, low: ArrayLike, high: ArrayLike, vertices: Numbers | None = None) -> Integers:
    """The triangles whose centres lie in a box in space.

    Args:
        cloth: the cloth.
        low: smallest coordinates of the box [cm], shape (3,).
        high: largest coordinates [cm], shape (3,).
        vertices: positions of the vertices [cm], shape (V, 3); those of the cloth if it is None.

    Raises:
        ParameterError: the box is not one of numbers in order, or holds no triangle.
    """
    places = cloth.vertices if vertices is None else np.asarray(vertices, dtype=np.float64)
    centre = places[cloth.triangles].mean(axis=1)
    inside = _inside(centre, low, high, "box")
    where = f"the cloth reaches from {_text(centre.min(axis=0))} to {_text(centre.max(axis=0))} cm"
    return _chosen(inside, f"box from {_text(low)} to {_text(high)} cm", where)


def triangles_in_rectangle(cloth: Cloth, panel: str, low: ArrayLike, high: ArrayLike) -> Integers:
    """The triangles of a panel whose centres lie in a rectangle in the coordinates of the panel.

    Args:
        cloth: the cloth.
        panel: name of the panel.
        low: smallest coordinates [cm], shape (2,).
        high: largest coordinates [cm], shape (2,).

    Raises:
        ParameterError: there is no such panel, the rectangle is not one of numbers in order, or it holds no triangle.
    """
    own = cloth.panel == _panel_number(cloth, panel)
    centre = cloth.rest.mean(axis=1)
    inside = own & _inside(centre, low, high, "rectangle")
    extent = centre[own]
    where = f"panel {panel!r} reaches from {_text(extent.min(axis=0))} to {_text(extent.max(axis=0))} cm"
    return _chosen(inside, f"rectangle from {_text(low)} to {_text(high)} cm", where)


def triangles_of_panels(cloth: Cloth, *panels: str) -> Integers:
    """The triangles of panels by name.

    Raises:
        ParameterError: there is no such panel.
    """
    return np.flatnonzero(np.isin(cloth.panel, [_panel_number(cloth, panel) for panel in panels]))


def triangles_of_faces(fabric: StitchMesh, faces: ArrayLike) -> Integers:
    """The triangles of faces of a stitch mesh, in the cloth of ``cloth_from_stitches``.

    Args:
        fabric: the stitch mesh.
        faces: numbers of faces, as ``sm.select`` returns them for a selection such as ``hem 6``.

    Raises:
        ParameterError: a number is not that of a face.
    """
    start = triangle_start(fabric)
    chosen = np.unique(np.asarray(faces, dtype=np.int64))
    if len(chosen) and (chosen[0] < 0 or chosen[-1] >= len(start) - 1):
        found = f"got face {chosen[0] if chosen[0] < 0 else chosen[-1]}"
        raise ParameterError(f"yarn placement: {found}; expected 0 to {len(start) - 2}")
    mask = np.zeros(len(start) - 1, dtype=bool)
    mask[chosen] = True
    return np.flatnonzero(np.repeat(mask, np.diff(start)))


def _panel_number(cloth: Cloth, panel: str) -> int:
    if panel not in cloth.panel_names:
        raise ParameterError(f"yarn placement: got panel {panel!r}; expected one of {', '.join(cloth.panel_names)}")
    return cloth.panel_names.index(panel)


def _inside(points: Numbers, low: ArrayLike, high: ArrayLike, name: str) -> NDArray[np.bool_]:
    """Whether each point lies between two corners."""
    least, most = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    size = points.shape[1]
    if least.shape != (size,) or most.shape != (size,) or not (least <= most).all():
        found = f"got {_text(low)} and {_text(high)}"
        raise ParameterError(f"yarn placement: {name}: {found}; expected {size} numbers each, the smaller ones first")
    return np.array(((points >= least) & (points <= most)).all(axis=1))


def _chosen(inside: NDArray[np.bool_], what: str, where: str) -> Integers:
    found = np.flatnonzero(inside)
    if len(found) == 0:
        raise ParameterError(f"yarn placement: the {what} holds no triangle; {where}")
    return found


def _text(values: ArrayLike) -> str:
    return f"({', '.join(f'{value:g}' for value in np.asarray(values, dtype=np.float64).ravel())})"
