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
from stitchmesh.settings import NOT_NEGATIVE, POSITIVE, check_settings, setting

Triple = tuple[float, float, float]
YARN_FORMATS = ("bcc", "h5", "usda", "usdc", "vtp", "obj", "glb")
"""Formats of yarns that a scene may write."""


@dataclass(frozen=True, kw_only=True)
class ContactSection:
    """Contact of the cloth with itself and with bodies.

    Raises:
        ParameterError: a number is out of bounds.
    """

    self_collision: bool = setting(False, "whether the cloth collides with itself")
    thickness: float | None = setting(
        None, "thickness of the cloth in contact", unit="cm", unset="four yarn radii, two layers at a crossing",
        **POSITIVE,
    )  # fmt: skip
    pressure: float | None = setting(
        None, "scale of the pressure of contact", unit="dyn/cm^2", unset="a value that suits cloth", **POSITIVE
    )
    friction: float = setting(
        0.0, "coefficient of friction between the layers of a cloth that moves and collides with itself", **NOT_NEGATIVE
    )
    start_outside: bool = setting(
        False, "whether a cloth that starts partly inside a body is moved out of it, while its strain spreads; "
        "otherwise a deep start is an error",
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_settings(self, "contact")


@dataclass(frozen=True, kw_only=True)
class SceneSolverSection:
    """Precision, processor and tolerances.

    Raises:
        ParameterError: a number is out of bounds.
    """

    precision: Literal["float32", "float64"] = setting(
        "float64", "floating-point type of the simulation; float32 is faster on a GPU"
    )
    device: str | None = setting(
        None, "processor, cpu or cuda:0", unset="the first GPU, or the CPU without a GPU"
    )
    velocity_tolerance: float = setting(
        0.5, "root mean square error of the velocities of a step of a dynamic run", unit="cm/s", **POSITIVE
    )
    force_tolerance: float = setting(
        0.01, "largest unbalanced force on a vertex or a node at a static equilibrium", unit="dyn", **POSITIVE
    )
    solve_tolerance: float = setting(1e-2, "relative tolerance of the linear solves", **POSITIVE)
    most_iterations: int = setting(
        500, "largest number of Newton iterations of one search for an equilibrium", **POSITIVE
    )
    friction_updates: int = setting(
        20, "largest number of times that a search for an equilibrium releases yarns that friction no longer holds; "
        "with 0, yarns stay where they cross in the layout, which is faster", **NOT_NEGATIVE,
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_settings(self, "solver")


@dataclass(frozen=True, kw_only=True)
class OutputSection:
    """The files and pictures that a run writes.

    Raises:
        ParameterError: a number is out of bounds, or a format is unknown.
    """

    frames_per_second: float = setting(30.0, "states of a dynamic run that are kept for each second", **POSITIVE)
    yarns: tuple[str, ...] = setting(("bcc",), f"formats of the yarns at the end: {', '.join(YARN_FORMATS)}")
    animation: bool = setting(True, "whether all frames are written as USD with time samples")
    picture: bool = setting(True, "whether a picture is drawn")
    colour: Literal["yarn", "alpha", "tension"] = setting(
        "yarn", "what decides the colours of the picture: yarn, alpha or tension"
    )
    view: tuple[float, float] = setting(
        (0.0, 0.0), "direction of the camera: azimuth (0 is the side of z, 90 the side of x) and elevation",
        unit="degrees",
    )  # fmt: skip
    size: tuple[int, int] = setting((1200, 900), "width and height of the picture", unit="pixels")
    subdivisions: int = setting(
        ROUNDS, "rounds of subdivision of the triangles for display", least=0, most=4, expected="0 to 4"
    )

    def __post_init__(self) -> None:
        check_settings(self, "output")
        unknown = [name for name in self.yarns if name not in YARN_FORMATS]
        if unknown:
            raise ParameterError(f"output.yarns: got {unknown[0]!r}; expected some of {', '.join(YARN_FORMATS)}")


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Everything that decides a run of the mixed system.

    Raises:
        ParameterError: a number is out of bounds, or keys contradict each other.
    """

    mode: Literal["static", "dynamic"] = setting(
        "static", "static: the cloth comes to an equilibrium; dynamic: it moves in time"
    )
    duration: float = setting(
        1.0, "time of a dynamic run; for a static run, the time of the keyframes at its end", unit="s", **POSITIVE
    )
    largest_step: float = setting(2e-3, "largest time step", unit="s", **POSITIVE)
    load_steps: int = setting(
        1, "number of equilibria of a static run, from the first place of attachments and bodies to the last one",
        **POSITIVE,
    )  # fmt: skip
    gravity: Triple = setting((0.0, -981.0, 0.0), "acceleration", unit="cm/s^2")
    disturbance: float = setting(
        0.0, "size of random displacements across the cloth at the start, so that a flat cloth can buckle; they are "
        "the same in each run", unit="cm", **NOT_NEGATIVE,
    )  # fmt: skip
    cloth: ClothSection
    """The cloth as triangles."""
    yarns: YarnsSection
    """The yarns that are laid out on it."""
    region: RegionSection = field(default_factory=RegionSection)
    """Where yarns are simulated."""
    attachments: tuple[AttachmentSection, ...] = ()
    """Parts of the cloth that are held or moved."""
    bodies: tuple[BodySection, ...] = ()
    """Bodies that the cloth cannot enter."""
    contact: ContactSection = field(default_factory=ContactSection)
    solver: SceneSolverSection = field(default_factory=SceneSolverSection)
    output: OutputSection = field(default_factory=OutputSection)

    def __post_init__(self) -> None:
        check_settings(self)
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
