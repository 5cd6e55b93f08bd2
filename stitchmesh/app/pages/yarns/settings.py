# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The user's choices on the page Yarns, and the arguments of the library that follow from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stitchmesh.app.controls.field_panel import Field, Number, TickBox, same_words, setting_field
from stitchmesh.app.pages.gauge_panel import yarn_of
from stitchmesh.app.pages.typed import file_name
from stitchmesh.compute.device import device_names
from stitchmesh.errors import StitchMeshError
from stitchmesh.io.checked import check_table
from stitchmesh.io.units import CENTIMETRES, DEFAULT_UNIT
from stitchmesh.pipeline.options import KnitOptions, RelaxOptions
from stitchmesh.quality import DEFAULT_QUALITY, PRESETS, Quality, quality_named, quality_with
from stitchmesh.recipe.recipe import relax_options
from stitchmesh.recipe.sections import (
    GarmentSettings,
    MaterialSection,
    PhysicsSection,
    RestLengthsSection,
    SolverSection,
)
from stitchmesh.run import Checkpoints
from stitchmesh.settings import declared_in
from stitchmesh.simulation.dead_load import EARTH
from stitchmesh.yarn.rest_length import RestLengths
from stitchmesh.yarn.stitch_size import stitch_size
from stitchmesh.yarn.yarn_presets import Yarn, format_yarn
from stitchmesh.yarngen.finish import YarnFinish
from stitchmesh.yarnrelax.constraints.pins import Pins
from stitchmesh.yarnrelax.model.material import NAMED

if TYPE_CHECKING:
    from stitchmesh.app.project.project import Project

AUTOMATIC = "automatic"
"""Entry of the list for the preferred device."""


@dataclass(frozen=True, kw_only=True)
class YarnSettings:
    """The choices on the page, in a form that JSON can hold.

    Zero stands for an automatic radius or limit, and for no force.
    """

    quality: str = DEFAULT_QUALITY
    """Preset of accuracy."""
    yarn_radius: float = 0.0
    """Yarn radius [cm]."""
    bind_off: str = declared_in(YarnFinish, "bind_off")
    cast_on: str = declared_in(YarnFinish, "cast_on")
    material: str | None = declared_in(MaterialSection, "name")
    rest_length: float = declared_in(RestLengthsSection, "factor")
    keep_shape: bool = True
    """Whether the borders and the shape of the garment are held."""
    gravity: float = 0.0
    """Weight of the yarn over its weight on Earth."""
    friction: float = 0.0
    """Coefficient of friction."""
    body: str = ""
    """Name of the file of a body in the project; empty without a body."""
    body_unit: str = declared_in(PhysicsSection, "body_unit")
    pins: tuple[int, ...] = ()
    """Stitches that do not move."""
    most_iterations: int = 0
    """Largest number of iterations of the relaxation."""
    device: str = AUTOMATIC

    def generation(self, yarn: Yarn | None) -> dict[str, Any]:
        """Return what decides the generated yarns, for JSON; they carry the project's yarn."""
        size = stitch_size(yarn, yarn_radius=self.yarn_radius or None)
        return {
            "quality": self.quality, "yarn_radius": size.yarn_radius, "bind_off": self.bind_off,
            "cast_on": self.cast_on, **({} if yarn is None else {"yarn": format_yarn(yarn)}),
        }  # fmt: skip

    def knit_options(self, yarn: Yarn | None, relaxation: RelaxOptions | None = None) -> KnitOptions:
        """Return the options of the stages that generate and relax the yarns.

        Raises:
            ParameterError: a name or a number is not valid.
        """
        size = stitch_size(yarn, yarn_radius=self.yarn_radius or None)
        return KnitOptions(
            yarn_radius=size.yarn_radius, drawn_radius=size.drawn_radius, mass_per_length=size.mass_per_length,
            yarn=yarn, finish=YarnFinish(bind_off=self.bind_off, cast_on=self.cast_on), quality=self.solver_quality(),
            device=None if self.device == AUTOMATIC else self.device, relaxation=relaxation or RelaxOptions(),
        )  # fmt: skip

    def solver_quality(self) -> Quality:
        """Return the quality of the relaxation.

        Raises:
            ParameterError: no preset has this name.
        """
        return quality_named(quality_with(self.quality, max_iterations=self.most_iterations or None))

    def relax_options(self, project: Project) -> RelaxOptions:
        """Return the options of the relaxation; the project holds the body.

        Raises:
            StitchMeshError: a name or a number is not valid, or the body cannot be read.
        """
        x, y, z = EARTH
        physics = PhysicsSection(
            gravity=(self.gravity * x, self.gravity * y, self.gravity * z) if self.gravity else None,
            friction=self.friction or None,
            body=str(body_path(project.folder, self.body)) if self.body else None,
            body_unit=self.body_unit if self.body else DEFAULT_UNIT,
        )
        lengths, yarn = RestLengths(factor=self.rest_length), yarn_of(project)
        options = relax_options(
            MaterialSection(name=self.material), physics, lengths, project.up, None if yarn is None else yarn.name
        )
        pins = (Pins(faces=self.pins),) if self.pins else ()
        return replace(options, terms=(*options.terms, *pins), keep_shape=self.keep_shape)

    def checkpoints(self, project: Project) -> Checkpoints:
        """Return the place and the interval of checkpoints.

        The interval is at most 400 iterations, a few seconds for a small garment, and at most as many as move
        40 million control points, half a minute of a processor; a loss of so little work is hardly noticed.
        """
        points = 1 if project.yarns is None else len(project.yarns.points)
        return Checkpoints(project.checkpoint_folder, max(1, min(400, 40_000_000 // points)))


FORCES = (
    Field("keep_shape", "Keep the shape", "Hold the borders and the shape of the garment"),
    setting_field(RestLengthsSection, "factor", "Yarn length", Number(0.5, 1.5, 0.01), at="rest_length"),
    Field("gravity", "Gravity", "Weight of the yarn over that on Earth; 0 is none", Number(0.0, 10.0, 0.1)),
    Field("friction", "Friction", "Coefficient of friction of yarns; 0 is none", Number(0.0, 2.0, 0.05)),
    setting_field(PhysicsSection, "body_unit", "Unit of the body", same_words(tuple(CENTIMETRES))),
)  # fmt: skip
"""The lengths and forces of the relaxation."""


def accuracy_fields(usual_radius: float) -> tuple[Field, ...]:
    """Return the fields of the accuracy and the edges; they propose the usual radius of the yarn [cm]."""
    radius = TickBox("Automatic yarn radius", "Take the radius of the yarn, or an eighth of the width of a stitch",
                 lambda settings: usual_radius)  # fmt: skip
    end = TickBox("Automatic end", "End at rest, or after the iterations of the quality", lambda settings: 1000)
    return (
        Field("quality", "Quality", "Accuracy and cost: draft is fast, reference is exact", same_words(tuple(PRESETS))),
        setting_field(GarmentSettings, "yarn_radius", "Yarn radius",
                      Number(0.001, 5.0, 0.005, without=0.0, box=radius)),
        setting_field(YarnFinish, "cast_on", "Cast-on"),
        setting_field(YarnFinish, "bind_off", "Bind-off"),
        setting_field(MaterialSection, "name", "Material",
                      {"of the yarn": None, **same_words(tuple(NAMED))}, at="material"),
        Field("device", "Device", "Processor that relaxes; automatic takes a GPU if there is one",
              same_words((AUTOMATIC, *device_names()))),
        setting_field(SolverSection, "max_iterations", "Most iterations",
                      Number(1, 1_000_000, 100, without=0, box=end), at="most_iterations"),
    )  # fmt: skip


def settings_of(table: Mapping[str, Any]) -> YarnSettings:
    """Return the settings from a table of ``settings_table``; the default settings if it has another form."""
    try:
        return check_table({**table, "pins": list(table.get("pins", ()))}, YarnSettings)
    except (StitchMeshError, TypeError):  # Another version of the program, or a user, wrote the file.
        return YarnSettings()


def settings_table(settings: YarnSettings) -> dict[str, Any]:
    """Return the settings as a table for JSON."""
    return asdict(settings) | {"pins": list(settings.pins)}


def decisive_choices(settings: YarnSettings) -> dict[str, Any]:
    """Return the choices that a continued relaxation must keep: all but the limit of iterations."""
    return {name: value for name, value in settings_table(settings).items() if name != "most_iterations"}


def body_path(folder: Path, name: str) -> Path:
    """Return the path of the file of a body in a project; folders in the name are left out."""
    return folder / "bodies" / file_name(name)
