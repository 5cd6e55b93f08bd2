# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a scene moves: attachments of the cloth, and bodies. Both move rigidly between keyframes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.mixed.contact.motion import RigidMotion
from stitchmesh.mixed.scene.region_section import BoxSection
from stitchmesh.mixed.scene.simple_bodies import ball, box

if TYPE_CHECKING:
    from stitchmesh.mesh import Mesh
    from stitchmesh.mixed.contact.body import Body

Triple = tuple[float, float, float]
STILL: Triple = (0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class Keyframe:
    """A place at a time."""

    time: float
    """Time [s]."""
    displacement: Triple = STILL
    """Displacement from the start [cm]."""
    rotation: Triple = STILL
    """Rotation from the start about the centre: its axis times its angle [degrees]."""


@dataclass(frozen=True, kw_only=True)
class AttachmentSection:
    """A part of the cloth that is held or moved: the vertices and yarn nodes in boxes.

    Raises:
        ParameterError: there is no box and no vertex, or keyframes are not in the order of their times.
    """

    boxes: tuple[BoxSection, ...] = ()
    """Boxes around the part, at the start."""
    vertices: tuple[int, ...] = ()
    """Numbers of vertices."""
    keyframes: tuple[Keyframe, ...] = ()
    """Motion; without it the part is held where it is."""
    centre: Triple = STILL
    """Centre of the rotations [cm]."""
    release: float | None = None
    """Time at which the part is free [s]; never by default."""

    def __post_init__(self) -> None:
        if not self.boxes and not self.vertices:
            raise ParameterError("attachment: got nothing that is attached; expected boxes or vertices")
        if self.release is not None and not (math.isfinite(self.release) and self.release > 0.0):
            raise ParameterError(f"attachment: release: got {self.release}; expected a positive time [s]")
        self.motion()

    def motion(self) -> RigidMotion:
        """Return the motion.

        Raises:
            ParameterError: the times of the keyframes do not increase.
        """
        return rigid_motion("attachment", self.keyframes, self.centre)


@dataclass(frozen=True, kw_only=True)
class BodySection:
    """A body that the cloth cannot enter.

    Raises:
        ParameterError: not exactly one of ``file`` and ``shape`` is given, or a number is not possible.
    """

    name: str = "body"
    """Name in messages and in the report."""
    file: str | None = None
    """A closed polygon mesh."""
    unit: str = DEFAULT_UNIT
    """Unit of the file."""
    shape: Literal["ball", "box"] | None = None
    """A shape instead of a file."""
    centre: Triple = STILL
    """Centre of the shape, and of the rotations [cm]."""
    size: tuple[float, ...] = ()
    """Radius of a ball, or the three side lengths of a box [cm]."""
    friction: float = 0.3
    """Coefficient of friction with the cloth."""
    thickness: float = 0.0
    """Thickness of a layer on the body that the cloth stays out of [cm]."""
    keyframes: tuple[Keyframe, ...] = ()
    """Motion; without it the body is at rest."""

    def __post_init__(self) -> None:
        if (self.file is None) == (self.shape is None):
            found = "neither" if self.file is None else "both"
            raise ParameterError(f"body {self.name!r}: got {found} of file and shape; expected one of them")
        expected = {"ball": 1, "box": 3}.get(self.shape or "", 0)
        if len(self.size) != expected or any(not (math.isfinite(side) and side > 0.0) for side in self.size):
            found = f"got {list(self.size)}"
            raise ParameterError(f"body {self.name!r}: size: {found}; expected {expected} positive numbers of cm")
        if not (math.isfinite(self.friction) and self.friction >= 0.0):
            raise ParameterError(f"body {self.name!r}: friction: got {self.friction}; expected at least 0")
        if not (math.isfinite(self.thickness) and self.thickness >= 0.0):
            raise ParameterError(f"body {self.name!r}: thickness: got {self.thickness}; expected at least 0 cm")
        self.motion()

    def motion(self) -> RigidMotion:
        """Return the motion.

        Raises:
            ParameterError: the times of the keyframes do not increase.
        """
        return rigid_motion(f"body {self.name!r}", self.keyframes, self.centre)

    def mesh(self) -> Mesh:
        """Return the surface at the start [cm].

        Raises:
            FileError: the file cannot be read.
        """
        from stitchmesh.io import read_mesh

        if self.file is not None:
            return read_mesh(self.file, unit=self.unit)
        return ball(self.size[0], self.centre) if self.shape == "ball" else box(self.size, self.centre)

    def body(self) -> Body:
        """Return the body.

        Raises:
            FileError: the file cannot be read.
            ParameterError: the surface is open or inside out.
        """
        from stitchmesh.mixed.contact.body import Body

        return Body(self.mesh(), self.motion(), self.name)


def rigid_motion(place: str, keyframes: tuple[Keyframe, ...], centre: Triple) -> RigidMotion:
    """Return the motion of keyframes; without any, that of what does not move.

    Raises:
        ParameterError: the times do not increase, or a number is not finite.
    """
    from scipy.spatial.transform import Rotation

    if not keyframes:
        return RigidMotion.at_rest()
    turns = np.radians([key.rotation for key in keyframes])
    try:
        return RigidMotion(
            np.array([key.time for key in keyframes]),
            np.array([key.displacement for key in keyframes]),
            Rotation.from_rotvec(turns).as_matrix(),
            np.array(centre),
        )
    except ParameterError as error:
        raise ParameterError(f"{place}: {error}") from error
