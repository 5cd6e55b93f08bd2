# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A scene of mixed yarns and triangles as numbers, texts and lists; the names of the fields are the keys of the file.

Lengths are in cm, times in s, masses in g; y points up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.output.display import ROUNDS
from stitchmesh.mixed.scene.cloth_section import ClothSection
from stitchmesh.mixed.scene.motion_section import AttachmentSection, BodySection
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.yarns_section import YarnsSection

Triple = tuple[float, float, float]
YARN_FORMATS = ("bcc", "h5", "usda", "usdc", "vtp", "obj", "glb")
"""Formats of yarns that a scene may write."""
LARGEST_NUMBER = 1e300
"""Largest number of a scene; whole numbers in a file may have any number of digits."""


@dataclass(frozen=True, kw_only=True)
class ContactSection:
    """Contact of the cloth with itself and with bodies.

    Raises:
        ParameterError: a number is not positive, or the friction is below 0.
    """

    self_collision: bool = False
    """Whether the cloth collides with itself."""
    thickness: float | None = None
    """Thickness of the cloth in contact [cm]; by default four yarn radii, which is two layers at a crossing."""
    pressure: float | None = None
    """Scale of the pressure of contact [dyn/cm^2]; the default suits cloth."""
    friction: float = 0.0
    """Coefficient of friction between the layers of a cloth that moves and collides with itself."""
    start_outside: bool = False
    """Whether a cloth that starts partly inside a body is moved out of it; if not, a deep start is an error."""

    def __post_init__(self) -> None:
        for name in ("thickness", "pressure"):
            value = getattr(self, name)
            if value is not None:
                check_positive(f"contact.{name}", value)
        if not (math.isfinite(self.friction) and self.friction >= 0.0):
            raise ParameterError(f"contact.friction: got {self.friction}; expected a number of at least 0")


@dataclass(frozen=True, kw_only=True)
class SolverSection:
    """Precision, processor and tolerances.

    Raises:
        ParameterError: a number is not positive.
    """

    precision: Literal["float32", "float64"] = "float64"
    """Floating-point type of the simulation."""
    device: str | None = None
    """Processor, ``cpu`` or ``cuda:0``; the first GPU by default, or the CPU without a GPU."""
    velocity_tolerance: float = 0.5
    """Root mean square error of the velocities of a step of a dynamic run [cm/s]."""
    force_tolerance: float = 0.01
    """Largest unbalanced force on a vertex or a node at a static equilibrium [dyn]."""
    solve_tolerance: float = 1e-2
    """Relative tolerance of the linear solves."""
    most_iterations: int = 500
    """Largest number of Newton iterations of one search for an equilibrium."""
    friction_updates: int = 20
    """Largest number of times that a search for an equilibrium releases yarns that friction no longer holds. With 0,
    yarns stay where they cross in the layout, which is faster."""

    def __post_init__(self) -> None:
        for name in ("velocity_tolerance", "force_tolerance", "solve_tolerance", "most_iterations"):
            check_positive(f"solver.{name}", getattr(self, name))
        if self.friction_updates < 0:
            raise ParameterError(f"solver.friction_updates: got {self.friction_updates}; expected at least 0")


@dataclass(frozen=True, kw_only=True)
class OutputSection:
    """The files and pictures that a run writes.

    Raises:
        ParameterError: a number is out of range, or a format is unknown.
    """

    frames_per_second: float = 30.0
    """States of a dynamic run that are kept for each second."""
    yarns: tuple[str, ...] = ("bcc",)
    """Formats of the yarns at the end, from ``YARN_FORMATS``."""
    animation: bool = True
    """Whether all frames are written as USD with time samples."""
    picture: bool = True
    """Whether a picture is drawn."""
    colour: Literal["yarn", "alpha", "tension"] = "yarn"
    """What decides the colours of the picture."""
    view: tuple[float, float] = (0.0, 0.0)
    """Direction of the camera [degrees]: azimuth (0 is the side of z, 90 the side of x) and elevation."""
    size: tuple[int, int] = (1200, 900)
    """Width and height of the picture [pixels]."""
    subdivisions: int = ROUNDS
    """Rounds of subdivision of the triangles for display."""

    def __post_init__(self) -> None:
        check_positive("output.frames_per_second", self.frames_per_second)
        unknown = [name for name in self.yarns if name not in YARN_FORMATS]
        if unknown:
            raise ParameterError(f"output.yarns: got {unknown[0]!r}; expected some of {', '.join(YARN_FORMATS)}")
        if not 0 <= self.subdivisions <= 4:
            raise ParameterError(f"output.subdivisions: got {self.subdivisions}; expected 0 to 4")


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Everything that decides a run of the mixed system.

    Raises:
        ParameterError: a number is out of range.
    """

    cloth: ClothSection
    """The cloth as triangles."""
    yarns: YarnsSection
    """The yarns that are laid out on it."""
    region: RegionSection = field(default_factory=RegionSection)
    """Where yarns are simulated."""
    mode: Literal["static", "dynamic"] = "static"
    """Whether the cloth comes to an equilibrium, or moves in time."""
    duration: float = 1.0
    """Time of a dynamic run [s]; for a static run, the time of the keyframes at its end."""
    largest_step: float = 2e-3
    """Largest time step [s]."""
    load_steps: int = 1
    """Number of equilibria of a static run, from the first place of attachments and bodies to the last one."""
    gravity: Triple = (0.0, -981.0, 0.0)
    """Acceleration [cm/s^2]."""
    disturbance: float = 0.0
    """Size of random displacements across the cloth at the start [cm], so that a flat cloth can buckle; they are the
    same in each run."""
    attachments: tuple[AttachmentSection, ...] = ()
    """Parts of the cloth that are held or moved."""
    bodies: tuple[BodySection, ...] = ()
    """Bodies that the cloth cannot enter."""
    contact: ContactSection = field(default_factory=ContactSection)
    solver: SolverSection = field(default_factory=SolverSection)
    output: OutputSection = field(default_factory=OutputSection)

    def __post_init__(self) -> None:
        for name in ("duration", "largest_step", "load_steps"):
            check_positive(name, getattr(self, name))
        if not (math.isfinite(self.disturbance) and self.disturbance >= 0.0):
            raise ParameterError(f"disturbance: got {self.disturbance}; expected a number of cm of at least 0")
        if self.yarns.model == "splines" and self.mode != "static":
            raise ParameterError(f"mode: got {self.mode!r} with B-spline yarns; expected 'static'")
        if self.mode == "static" and self.contact.friction:
            raise ParameterError(
                f"contact.friction: got {self.contact.friction} in a static scene, whose layers slide freely; expected "
                '0, or mode = "dynamic"'
            )
        if self.mode == "dynamic" and self.region.start != "layout":
            raise ParameterError(
                f"region.start: got {self.region.start!r} in a dynamic scene; expected 'layout', or mode = \"static\""
            )
        if not all(math.isfinite(part) for part in self.gravity):
            raise ParameterError(f"gravity: got {list(self.gravity)}; expected three finite numbers of cm/s^2")

    @property
    def equilibria(self) -> int:
        """Number of equilibria that a static run finds with its yarns."""
        return 1 if self.region.starts_on_triangles else self.load_steps


def check_positive(name: str, value: float) -> None:
    """Check that a value is a positive number.

    Raises:
        ParameterError: it is not positive, or larger than ``LARGEST_NUMBER``.
    """
    if not 0 < value <= LARGEST_NUMBER:
        raise ParameterError(f"{name}: got {value}; expected a positive number of at most {LARGEST_NUMBER:g}")
