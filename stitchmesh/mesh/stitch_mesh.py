# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitch meshes: polygon meshes whose faces are oriented in the knitting frame."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import overload

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import LabelError, first_few
from stitchmesh.mesh.own_stitch import FIRST_OWN, OwnStitch, StitchType
from stitchmesh.mesh.palette import Palette, checked_palette, empty_palette
from stitchmesh.mesh.polygon_mesh import BORDER, FloatArray, IntArray, Mesh, extent, frozen_array
from stitchmesh.mesh.stitch import SIDE_COUNTS, VOCABULARY, Making, Stitch

BOTTOM, RIGHT, TOP, LEFT = range(4)
"""Roles of the sides of a stitch face: bottom and top sides are course sides, right and left sides are wale sides."""
PER_FACE = ("n_bottom", "n_top", "stitch", "row", "yarn")
"""Fields of a stitch mesh with one number per face."""
PER_SIDE = ("twist", "cable_shift", "cable_layer")
"""Marks of loops: fields of a stitch mesh with one number per side."""
_FIXED_SIDES = np.array([SIDE_COUNTS.get(stitch, (-1, -1)) for stitch in sorted(Stitch)])
_UNUSED_SIDES = np.full((FIRST_OWN - len(_FIXED_SIDES), 2), -1)
"""Number of bottom and of top sides by type code; -1 if any number is allowed."""


def _unmarked() -> IntArray:
    """Return an empty array, the default of a mark; the constructor replaces it by zeros of the right length."""
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, eq=False, kw_only=True)
class StitchMesh(Mesh):
    """A mesh whose faces are oriented in the knitting frame (Yuksel et al. 2012, section 4).

    The corners of each face are ordered so that its sides run counter-clockwise from the lower left: ``n_bottom``
    bottom course sides, the right wale side, ``n_top`` top course sides (right to left), and the left wale side. The
    role of a side follows from its place in the face, so that no stored edge label can contradict it.

    Raises:
        MeshError: as for ``Mesh``.
        LabelError: a face does not have exactly two wale sides, an edge is a wale edge of one face and a course edge
            of the other, a stitch has the wrong number of sides, a side that is not a top side carries a mark, or the
            palette is not an array of bytes of shape (P, 3).
    """

    n_bottom: IntArray
    """Number of bottom course sides of each face, shape (F,)."""
    n_top: IntArray
    """Number of top course sides of each face, shape (F,)."""
    stitch: IntArray
    """Type code of each face (``Stitch``), shape (F,)."""
    row: IntArray
    """Row of each face, numbered in knitting order, shape (F,)."""
    yarn: IntArray = field(default_factory=_unmarked)
    """Number of the yarn (its colour) that each face is knitted with, shape (F,); all 0 by default."""
    twist: IntArray = field(default_factory=_unmarked)
    """Half turn of the loop on each top side: 1 (the left leg is in front), -1 (the right leg) or 0, shape (C,)."""
    cable_shift: IntArray = field(default_factory=_unmarked)
    """Number of places by which the loop on each top side moves to the right before it is worked, shape (C,)."""
    cable_layer: IntArray = field(default_factory=_unmarked)
    """Layer of the loop on each top side, shape (C,); where two loops cross, the higher layer is in front."""
    stretch: FloatArray | None = None
    """Length divided by rest length of each edge after mesh relaxation, shape (E,); None before mesh relaxation."""
    palette: Palette = field(default_factory=empty_palette)
    """Colour of each yarn number (sRGB), shape (P, 3); numbers beyond it have stock colours (``mesh.palette``)."""
    own_stitches: tuple[OwnStitch, ...] = field(default=(), metadata={"stored": False})
    """Stitches of the user's own; the type code of the first is ``own_stitch.FIRST_OWN``."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("n_bottom", "n_top", "stitch", "row"):
            values = frozen_array(getattr(self, name), np.int64)
            if values.shape != (self.face_count,):
                raise LabelError(f"{name}: got shape {values.shape}; expected one number per face")
            object.__setattr__(self, name, values)
        self._fill_marks()
        object.__setattr__(self, "palette", checked_palette(self.palette, LabelError))
        if self.stretch is not None:
            object.__setattr__(self, "stretch", frozen_array(self.stretch, np.float64))
        self.check_stitch_faces(np.arange(self.face_count))
        if self.stretch is not None and self.stretch.shape != (len(self.edge_side),):
            raise LabelError(f"stretch: got shape {self.stretch.shape}; expected one number per edge")

    def __repr__(self) -> str:
        """Return one line: the number of stitches, or of panels if the mesh is labeled only, the rows, and the size."""
        kind = "panels" if (self.stitch == Stitch.PANEL).all() else "stitches"
        periodic = ", periodic" if self.lattice is not None else ""
        counts = f"{self.face_count} {kind} in {len(np.unique(self.row))} rows"
        return f"{type(self).__name__}({counts}, {extent(self.vertices)}{periodic})"

    def _fill_marks(self) -> None:
        counts = {"yarn": self.face_count, **dict.fromkeys(PER_SIDE, self.side_count)}
        for name, count in counts.items():
            values = np.asarray(getattr(self, name), dtype=np.int64)
            values = frozen_array(values if values.size else np.zeros(count), np.int64)
            if values.shape != (count,):
                raise LabelError(f"{name}: got shape {values.shape}; expected ({count},)")
            object.__setattr__(self, name, values)

    @cached_property
    def side_role(self) -> IntArray:
        """Role of each side: ``BOTTOM``, ``RIGHT``, ``TOP`` or ``LEFT``, shape (C,)."""
        return self.role_of(np.arange(self.side_count))

    @overload
    def role_of(self, sides: int) -> int: ...
    @overload
    def role_of(self, sides: IntArray) -> IntArray: ...
    def role_of(self, sides: IntArray | int) -> IntArray | int:
        """Role of one side or of several sides, computed for these sides only."""
        face = self.side_face[sides]
        above = sides - self.face_start[face] - self.n_bottom[face]  # This is 0 on the right wale side.
        role: IntArray = (above >= 0) + 1 * (above > 0) + (above > self.n_top[face])
        return role

    @cached_property
    def side_place(self) -> IntArray:
        """Place of each side within its face, counted from the lower left, shape (C,)."""
        return np.arange(self.side_count) - self.face_start[:-1][self.side_face]

    @cached_property
    def is_wale(self) -> NDArray[np.bool_]:
        """Whether each side is a wale side, shape (C,)."""
        return self.side_role % 2 == 1

    @cached_property
    def right_wale(self) -> IntArray:
        """Right wale side of each face, shape (F,)."""
        return self.face_start[:-1] + self.n_bottom

    @cached_property
    def left_wale(self) -> IntArray:
        """Left wale side of each face, shape (F,)."""
        return self.face_start[1:] - 1

    @cached_property
    def mismatched(self) -> NDArray[np.bool_]:
        """Whether a side and its twin have the same role, so that wale directions differ (section 4.4), shape (C,)."""
        across = np.where(self.twin == BORDER, 0, self.twin)
        return (self.twin != BORDER) & (self.side_role == self.side_role[across])

    @cached_property
    def slipped_from(self) -> IntArray:
        """The bottom side from which the slipped loop at each top side comes, ``BORDER`` for no slip, shape (C,)."""
        result = np.full(self.side_count, BORDER)
        for stitch, making in self.makings.items():
            for loop in (place for place, made in enumerate(making.made) if made == "s"):
                # a stitch that slips a loop has one bottom side, the first side of its face
                first = self.face_start[:-1][self.stitch == stitch]
                result[first + making.n_bottom + making.n_top - loop] = first  # top sides run from right to left
        return result

    @cached_property
    def face_stretch(self) -> FloatArray | None:
        """Mean stretch of the edges of each face, shape (F,); None before mesh relaxation."""
        if self.stretch is None:
            return None
        total = np.add.reduceat(self.stretch[self.side_edge], self.face_start[:-1])
        return total / np.diff(self.face_start)

    @cached_property
    def built_in(self) -> IntArray:
        """Type code of each face, with ``KNIT`` in the place of stitches of the user's own, shape (F,)."""
        return np.where(self.stitch >= FIRST_OWN, int(Stitch.KNIT), self.stitch)

    def type_code(self, stitch: StitchType) -> int:
        """Return the type code of a stitch, built in or among ``own_stitches``."""
        return FIRST_OWN + self.own_stitches.index(stitch) if isinstance(stitch, OwnStitch) else int(stitch)

    def stitch_type(self, code: int) -> StitchType:
        """Return the stitch of a type code.

        Raises:
            ValueError: the code belongs neither to ``Stitch`` nor to a stitch of the user's own.
        """
        return self.own_stitches[code - FIRST_OWN] if code >= FIRST_OWN else Stitch(code)

    @cached_property
    def makings(self) -> dict[int, Making]:
        """How each stitch of a pattern is made, by type code: the built-in stitches, then the user's own stitches."""
        own = {FIRST_OWN + number: stitch.making for number, stitch in enumerate(self.own_stitches)}
        return {**{int(stitch): making for stitch, making in VOCABULARY.items()}, **own}

    @cached_property
    def _fixed_sides(self) -> IntArray:
        """Number of bottom and of top sides by type code, -1 if any number is allowed, shape (codes, 2)."""
        if not self.own_stitches:
            return _FIXED_SIDES
        own = [(stitch.making.n_bottom, stitch.making.n_top) for stitch in self.own_stitches]
        return np.concatenate([_FIXED_SIDES, _UNUSED_SIDES, own])

    def check_stitch_faces(self, faces: IntArray) -> None:
        """Check that the given faces are legal stitch faces and match their neighbours.

        Raises:
            LabelError: as for the class.
        """
        sides = self.sides_of(faces)
        self._check_sides(faces, sides)
        self._check_stitches(faces)
        self._check_marks(faces, sides)

    def _check_sides(self, faces: IntArray, sides: IntArray) -> None:
        sizes, bottom, top = np.diff(self.face_start)[faces], self.n_bottom[faces], self.n_top[faces]
        bad = np.flatnonzero((bottom < 0) | (top < 0) | (bottom + top + 2 != sizes))
        if len(bad):
            found = f"{bottom[bad[0]]} bottom and {top[bad[0]]} top sides of {sizes[bad[0]]}"
            raise LabelError(f"face {faces[bad[0]]}: got {found}; a stitch face needs exactly 2 more, its wale sides")
        across = np.where(self.twin[sides] == BORDER, sides, self.twin[sides])
        bad = sides[self.role_of(sides) % 2 != self.role_of(across) % 2]
        if len(bad):
            other = self.side_face[self.twin[bad[0]]]
            raise LabelError(f"{self.side_name(bad[0])}: wale to one face and course to face {other}")

    def _check_stitches(self, faces: IntArray) -> None:
        stitch = self.stitch[faces]
        own = (stitch >= FIRST_OWN) & (stitch < FIRST_OWN + len(self.own_stitches))
        unknown = stitch[((stitch < 0) | (stitch > max(Stitch))) & ~own]
        if len(unknown):
            raise LabelError(f"stitch: got code {unknown[0]}; expected 0 to {max(Stitch)}, or that of an own stitch")
        bottom, top = self._fixed_sides[stitch].T
        bad = np.flatnonzero((bottom >= 0) & ((self.n_bottom[faces] != bottom) | (self.n_top[faces] != top)))
        if len(bad):
            face, making = faces[bad[0]], self.makings.get(int(stitch[bad[0]]))
            name = making.instruction if making else self.stitch_type(int(stitch[bad[0]])).name.lower()
            found = f"{self.n_bottom[face]} bottom and {self.n_top[face]} top sides"
            raise LabelError(f"face {face}: {name} on {found}; it needs {bottom[bad[0]]} and {top[bad[0]]}")

    def _check_marks(self, faces: IntArray, sides: IntArray) -> None:
        for name in PER_SIDE:
            marked = sides[getattr(self, name)[sides] != 0]
            bad = marked[self.role_of(marked) != TOP]
            if len(bad):
                raise LabelError(f"{self.side_name(bad[0])}: has a {name}; only top sides of a face carry one")
        bad = sides[np.abs(self.twist[sides]) > 1]
        if len(bad):
            raise LabelError(f"{self.side_name(bad[0])}: twist {self.twist[bad[0]]}; expected -1, 0 or 1")
        bad = faces[self.yarn[faces] < 0]
        if len(bad):
            raise LabelError(f"face {first_few(bad)}: got yarn {self.yarn[bad[0]]}; yarns are numbered from 0")
