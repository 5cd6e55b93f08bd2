# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The moving parts of a scene: attachments of the cloth, and bodies. Both move rigidly between keyframes."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.mesh.vertex_motion import VertexMotion
from stitchmesh.mixed.contact.motion import RigidMotion
from stitchmesh.mixed.scene.region_section import BoxSection
from stitchmesh.mixed.scene.simple_bodies import Arm, ball, box, check_bend
from stitchmesh.settings import NOT_NEGATIVE, POSITIVE, check_settings, setting

if TYPE_CHECKING:
    from stitchmesh.mesh import Mesh
    from stitchmesh.mixed.contact.body import SolidBody

Triple = tuple[float, float, float]
STILL: Triple = (0.0, 0.0, 0.0)
BEND_STEP = 2.0
"""Largest difference in the bend of an elbow between two neighbouring shapes of an arm [degrees]. Its vertices move
along straight lines between these shapes."""


@dataclass(frozen=True, kw_only=True)
class Keyframe:
    """A place at a time."""

    time: float
    """Time [s]."""
    displacement: Triple = STILL
    """Displacement from the start [cm]."""
    rotation: Triple = STILL
    """Rotation from the start about the centre: its axis times its angle [degrees]."""
    bend: float = 0.0
    """Bend of the elbow of an arm [degrees]; 0 is straight."""


@dataclass(frozen=True, kw_only=True)
class AttachmentSection:
    """A part of the cloth that is held or moved: the vertices and yarn nodes in boxes and in triangles.

    Raises:
        ParameterError: there is no box, triangle or vertex, or keyframes are not in the order of their times.
    """

    boxes: tuple[BoxSection, ...] = setting((), "boxes around the part at the start, in space or in a panel")
    vertices: tuple[int, ...] = setting((), "numbers of vertices")
    faces: tuple[int, ...] = setting(
        (), "numbers of triangles; their vertices and the yarn nodes in them are held, unless an attachment listed "
        "before holds them",
    )  # fmt: skip
    keyframes: tuple[Keyframe, ...] = setting(
        (), "motion: time [s], displacement [cm] and rotation [degrees] from the start; without it the part stays"
    )
    centre: Triple = setting(STILL, "centre of the rotations", unit="cm")
    release: float | None = setting(
        None, "time from which the part is free; without one it is held to the end", unit="s", unset="never", **POSITIVE
    )

    def __post_init__(self) -> None:
        check_settings(self, "attachment")
        if not (self.boxes or self.vertices or self.faces):
            raise ParameterError("attachment: got nothing that is attached; expected boxes, faces or vertices")
        if any(key.bend for key in self.keyframes):
            raise ParameterError("attachment: keyframes: got a bend; expected one in the keyframes of an arm alone")
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

    name: str = setting("body", "name in messages and in the report")
    file: str | None = setting(None, "a closed polygon mesh", unset="none")
    unit: str = setting(DEFAULT_UNIT, "unit of the file")
    shape: Literal["ball", "box", "arm"] | None = setting(
        None, "a shape instead of a file: ball, box or arm", unset="none"
    )
    centre: Triple = setting(
        STILL, "centre of the shape, which is the elbow of an arm, and of the rotations", unit="cm"
    )
    size: tuple[float, ...] = setting(
        (), "radius of a ball; the three side lengths of a box; radius, upper part (along y from the elbow) and "
        "forearm (along -y) of an arm", unit="cm",
    )  # fmt: skip
    friction: float = setting(0.3, "coefficient of friction with the cloth", **NOT_NEGATIVE)
    thickness: float = setting(
        0.0, "thickness of a layer on the body that the cloth stays out of", unit="cm", **NOT_NEGATIVE
    )
    keyframes: tuple[Keyframe, ...] = setting(
        (), "motion, as for attachments; keyframes of an arm also bend its elbow [degrees]; without it it rests"
    )

    def __post_init__(self) -> None:
        if (self.file is None) == (self.shape is None):
            found = "neither" if self.file is None else "both"
            raise ParameterError(f"body {self.name!r}: got {found} of file and shape; expected one of them")
        expected = {"ball": 1, "box": 3, "arm": 3}.get(self.shape or "", 0)
        if len(self.size) != expected or any(not (math.isfinite(side) and side > 0.0) for side in self.size):
            found = f"got {list(self.size)}"
            raise ParameterError(f"body {self.name!r}: size: {found}; expected {expected} positive numbers of cm")
        check_settings(self, f"bodies ({self.name})")
        if self.shape != "arm" and any(key.bend for key in self.keyframes):
            raise ParameterError(f"body {self.name!r}: keyframes: got a bend; expected one of an arm alone")
        self._motion(bend_step=math.inf)  # a check; all places between the keyframes would take long for many arms

    def motion(self) -> RigidMotion | VertexMotion:
        """Return the motion.

        Raises:
            ParameterError: the times of the keyframes do not increase, or a bend is not possible.
        """
        return self._motion(bend_step=BEND_STEP)

    def _motion(self, *, bend_step: float) -> RigidMotion | VertexMotion:
        rigid = rigid_motion(f"body {self.name!r}", self.keyframes, self.centre)
        return self._bending(rigid, bend_step) if self.shape == "arm" else rigid

    def _bending(self, rigid: RigidMotion, bend_step: float) -> VertexMotion:
        """Places of the vertices of an arm, at times between which its elbow bends by at most one step."""
        keys = self.keyframes or (Keyframe(time=0.0),)
        bends = [key.bend for key in keys]
        for each in bends:
            check_bend(each)
        steps = max(int(np.ceil(np.abs(np.diff(bends)).max(initial=0.0) / bend_step)), 1)
        part = np.arange(steps * (len(keys) - 1) + 1) / steps
        times = np.interp(part, np.arange(len(keys)), rigid.times)
        arm, bend = Arm(*self.size), np.interp(part, np.arange(len(keys)), bends)
        places = [
            rigid.places_at(arm.vertices(float(angle)) + np.array(self.centre), float(time))
            for angle, time in zip(bend, times, strict=True)
        ]
        return VertexMotion(times, np.array(places))

    def mesh(self) -> Mesh:
        """Return the surface at the start [cm].

        Raises:
            FileError: the file cannot be read.
        """
        from stitchmesh.io import read_mesh

        if self.file is not None:
            return read_mesh(self.file, unit=self.unit)
        motion = self.motion()
        if isinstance(motion, VertexMotion):
            return replace(Arm(*self.size).mesh(), vertices=motion.vertices[0])
        return ball(self.size[0], self.centre) if self.shape == "ball" else box(self.size, self.centre)

    def body(self) -> SolidBody:
        """Return the body.

        Raises:
            FileError: the file cannot be read.
            ParameterError: the surface is open or inside out.
        """
        from stitchmesh.mixed.contact.body import SolidBody

        return SolidBody(self.mesh(), self.motion(), self.name)


def rigid_motion(place: str, keyframes: tuple[Keyframe, ...], centre: Triple) -> RigidMotion:
    """Return the motion of keyframes; without keyframes, the motion of a body at rest.

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
