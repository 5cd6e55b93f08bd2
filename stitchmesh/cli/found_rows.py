# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Options of rows that are found: on a mesh of any kind, as panels of a labeled mesh, or on a sewing pattern.

The docstring of a field is the help text of the option.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Annotated, Any

from tyro.conf import UseAppendAction

from stitchmesh.cli.arguments import Flag, PanelDirection, PanelPair, help_entry
from stitchmesh.cli.options import StitchWidth, YarnAndGauge
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.recipe.sections import DirectionTable, MarkTable, PanelsSection, RowsSection
from stitchmesh.shaping.options import DEFAULT_PLACEMENT, PANEL_SIZE, Placement, ShapingOptions
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING, STITCH_WIDTH


@dataclass(frozen=True)
class RowFinding:
    """Rows that are found on a mesh of any kind, in the place of the labeled rows of a modelled mesh."""

    auto: Flag = False
    """find rows and stitches on any mesh, also of triangles; the mesh is repaired first"""
    multiple: Annotated[int, help_entry("N")] = ShapingOptions.multiple
    """number that the stitches of each round are a multiple of, for a pattern that repeats"""
    no_short_rows: Flag = not ShapingOptions.short_rows
    """do not turn the yarn back within the fabric where rows are far too high, as at a heel"""
    marks: Annotated[str | None, help_entry("FILE", "automatic")] = None
    """JSON list of places where knitting begins and ends, where a row runs, or where no shaping is (docs/recipes.md)"""
    most_shaping: Annotated[float | None, help_entry("PART", "as the mesh asks")] = ShapingOptions.most_shaping
    """largest part of the stitches of a row that are increases or decreases, such as 0.25"""
    shaping: Annotated[Placement, help_entry("WHERE")] = DEFAULT_PLACEMENT
    """increases and decreases: seams (stacked at sides, raglan lines and edges, in a rhythm) or spread over the row"""

    def section(self, *, panels: bool = False) -> RowsSection:
        """Return the section of a recipe.

        Args:
            panels: whether panels are knitted, which have the placement of increases and decreases in their section.

        Raises:
            FileError: the file of the marks cannot be read, or has a key or a value that no mark has.
            ParameterError: another option is given without ``--auto``, a number is out of bounds, or a mark is not
                possible.
        """
        return RowsSection(
            auto=self.auto, multiple=self.multiple, short_rows=not self.no_short_rows,
            marks=() if self.marks is None else _read_marks(self.marks), most_shaping=self.most_shaping,
            shaping=DEFAULT_PLACEMENT if panels else self.shaping,
        )  # fmt: skip


@dataclass(frozen=True)
class FoundPanels:
    """Size of the panels of a labeled mesh whose rows are found."""

    stitch_width: StitchWidth = None
    yarn: YarnAndGauge = field(default_factory=YarnAndGauge)
    course_height: Annotated[float | None, help_entry("CM", f"{COURSE_OVER_WALE_SPACING} stitch widths")] = None
    """course spacing [cm]"""
    panel_size: Annotated[int, help_entry("N")] = PANEL_SIZE
    """stitches along a panel, and courses in a row of panels"""

    def arguments(self) -> dict[str, Any]:
        """Return arguments of ``auto_labels``.

        Raises:
            ParameterError: as for ``YarnAndGauge.size``.
        """
        size = self.yarn.size(stitch_width=self.stitch_width, stitch_height=self.course_height)
        width = STITCH_WIDTH if size.stitch_width is None else size.stitch_width
        return {"stitch_width": width, "stitch_height": size.stitch_height, "panel_size": self.panel_size}

    def refuse(self) -> None:
        """Check that nothing is given, because the panels are the faces of the mesh.

        Raises:
            ParameterError: a size is given.
        """
        for part in fields(self):
            if getattr(self, part.name) != getattr(FoundPanels(), part.name):
                raise ParameterError(f"{part.name}: is for rows that are found; give auto (--auto) too")


@dataclass(frozen=True)
class KnittedPanels:
    """Panels of a sewing pattern, each knitted in its own direction."""

    panels: Flag = False
    """knit the mesh as a sewing pattern, panel by panel, by its texture coordinates or groups (docs/panels.md)"""
    panel_direction: Annotated[
        UseAppendAction[tuple[PanelDirection, ...]], help_entry("PANEL=U,V", "0,1: up in the pattern")
    ] = ()
    """direction of knitting of a panel in its texture; PANEL is a number, or the name of objects or groups"""
    sew: Annotated[UseAppendAction[tuple[PanelPair, ...]], help_entry("PANEL,PANEL")] = ()
    """two panels whose seams are left to be sewn, also where their stitches fit"""

    def section(self, shaping: Placement) -> PanelsSection:
        """Return the section of a recipe.

        Args:
            shaping: where increases and decreases stand, if panels are knitted.

        Raises:
            ParameterError: another option is given without ``--panels``, or a direction is zero or not finite.
        """
        directions = tuple(DirectionTable(panel=name, direction=along) for name, along in self.panel_direction)
        placement = shaping if self.panels else DEFAULT_PLACEMENT
        return PanelsSection(knit=self.panels, directions=directions, sewn=self.sew, shaping=placement)


def _read_marks(path: str) -> tuple[MarkTable, ...]:
    """Read the marks of a JSON file.

    Raises:
        FileError: the file cannot be read, or has a key or a value that no mark has.
    """
    from stitchmesh.io.checked import check_table, read_json

    try:
        return check_table(read_json(path), tuple[MarkTable, ...])
    except ParameterError as error:
        raise FileError(f"{path}: {error}") from error
