# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tables of a job file for a swatch and for pictures.

Values are numbers, texts and lists, as TOML holds them.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Literal

from stitchmesh.periodic.swatch_options import ReleaseSettings, RepeatSettings, SwatchOptions
from stitchmesh.quality import Quality, quality_named, quality_with
from stitchmesh.recipe.sections import FACTORS, MaterialSection, SolverSection
from stitchmesh.render.options import PICTURE_SIZE, PictureOptions
from stitchmesh.settings import declared_in, setting
from stitchmesh.yarn.rest_length import parse_rest_lengths
from stitchmesh.yarnrelax.model.material import YarnMaterial

Free = Literal["free"]


@dataclass(frozen=True, kw_only=True)
class SwatchTable(RepeatSettings, ReleaseSettings):
    """One repeat of a pattern or weave, and how it relaxes."""

    pattern: str
    """Name of a pattern or weave of the library, or the path of a chart."""
    yarn_radius: float = declared_in(SwatchOptions, "yarn_radius")
    drawn_radius: float | None = declared_in(SwatchOptions, "drawn_radius")
    mass_per_length: float | None = declared_in(SwatchOptions, "mass_per_length")
    rest_lengths: tuple[str, ...] = setting(
        (), f"factor of rest lengths, 0.1 to 2, {FACTORS}, or for warp=F or weft=F of a weave", flag="rest-length",
        form="KEY=F",
    )  # fmt: skip
    period: tuple[float | Free, float | Free] = setting(
        ("free", "free"), "width and height of the repeat, each a number or the word free", unit="cm", form="CM CM",
        unset="as generated",
    )  # fmt: skip
    material: str | None = declared_in(MaterialSection, "name")
    stiffness: tuple[str, ...] = declared_in(MaterialSection, "stiffness")
    max_iterations: int | None = declared_in(SolverSection, "max_iterations")

    def __post_init__(self) -> None:
        """Leave the check of bounds to ``options``, so that a job of a sweep keeps its error in its own row."""

    def options(self) -> SwatchOptions:
        """Return the options of the swatch.

        Raises:
            ParameterError: a value is out of bounds.
        """
        own = {part.name for part in fields(self)}
        given = {part.name: getattr(self, part.name) for part in fields(SwatchOptions) if part.name in own}
        period = tuple(None if size == "free" else size for size in self.period)
        return SwatchOptions(**given | {"rest_lengths": parse_rest_lengths(self.rest_lengths), "period": period})

    def yarn_material(self) -> YarnMaterial:
        """Return the material of the yarn.

        Raises:
            ParameterError: the material or a value is unknown, a value is out of bounds, or the yarn has two masses.
        """
        section = MaterialSection(name=self.material, stiffness=self.stiffness)
        return section.yarn_material(self.yarn_radius, self.mass_per_length)

    def quality(self, preset: str) -> Quality:
        """Return the preset with the limit of iterations."""
        return quality_named(quality_with(preset, max_iterations=self.max_iterations))

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of ``swatch`` except for the pattern, the quality and the device."""
        return dict(vars(self.options()))


@dataclass(frozen=True, kw_only=True)
class RenderTable:
    """Arguments of ``render``."""

    path: str = "preview.png"
    """Picture in the folder of the job."""
    view: str | None = None
    """Direction of the camera; None for the front."""
    size: tuple[int, int] = PICTURE_SIZE
    """Width and height [pixels]."""
    colour: str | None = None
    """``yarn``, ``row``, ``stitch``, ``strain``, ``contact`` or a colour; None for the colours of the yarns."""
    tiles: tuple[int, int] = (5, 5)
    """Repeats of a swatch, along the courses and along the wales."""

    def options(self) -> dict[str, Any]:
        """Return the options of ``render``.

        Raises:
            ParameterError: a value is not possible.
        """
        given: dict[str, Any] = {"view": self.view, "size": self.size, "colour": self.colour}
        PictureOptions(**given)
        return given
