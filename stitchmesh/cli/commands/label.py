# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``label``."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional, UseAppendAction, arg

from stitchmesh.cli.options import CourseHeight, Overwrite, StitchWidth
from stitchmesh.cli.say import say
from stitchmesh.cli.words import Pair, help_entry, pair, parsed_by
from stitchmesh.errors import ParameterError
from stitchmesh.io.mesh_reading import MeshReading
from stitchmesh.recipe.sections import LabelSection, RowsSection, YarnAndGauge
from stitchmesh.shaping.options import DEFAULT_PLACEMENT, PANEL_SIZE
from stitchmesh.tessellate import STITCH_WIDTH

if TYPE_CHECKING:
    from stitchmesh.labeling import PartialLabeling
    from stitchmesh.recipe.recipe import Recipe

CLEAR = "clear"
"""Word for the removal of the label of an edge."""


def _edge_with_label(text: str) -> tuple[tuple[int, int], str | None]:
    edge, _, label = text.partition("=")
    if label not in ("course", "wale", CLEAR):
        raise ValueError(f"got {text!r}; expected V,W=course, V,W=wale or V,W={CLEAR}")
    return pair(edge), None if label == CLEAR else label


EdgeWithLabel = Annotated[tuple[tuple[int, int], str | None], parsed_by(_edge_with_label, "V,W=LABEL", str)]
"""The two vertices of an edge and its label in one word; None for no label."""


@dataclass(frozen=True)
class FoundPanels:
    """Size of the panels of a labeled mesh whose rows are found."""

    stitch_width: StitchWidth = None
    yarn: YarnAndGauge = field(default_factory=YarnAndGauge)
    course_height: CourseHeight = None
    panel_size: Annotated[int, help_entry("N")] = PANEL_SIZE
    """stitches along a panel, and courses in a row of panels"""

    def arguments(self) -> dict[str, Any]:
        """Return arguments of ``auto_labels``.

        Raises:
            ParameterError: as for ``stitch_size``.
        """
        size = self.yarn.measures(stitch_width=self.stitch_width, stitch_height=self.course_height)
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
class LabelCommand:
    """Find the knitting rows of a polygon mesh, all at once or step by step."""

    mesh: Annotated[Positional[str], help_entry("MESH")]
    """polygon mesh (OBJ, PLY, OFF, STL, VTK ...), or a labeled or partly labeled mesh (.h5), which is continued"""
    output: Annotated[str, help_entry("FILE", short="-o")]
    """labeled mesh: .h5 or .smobj; with --rows a partly labeled mesh: .h5"""
    in_file: Annotated[MeshReading, arg(name="")] = field(default_factory=MeshReading)
    set_edge: Annotated[UseAppendAction[tuple[EdgeWithLabel, ...]], help_entry("V,W=LABEL")] = ()
    """label of one edge, set by hand before rows are labeled: course, wale, or clear for no label"""
    starts: Annotated[LabelSection, arg(name="")] = field(default_factory=LabelSection)
    row_at: Annotated[UseAppendAction[tuple[Pair, ...]], help_entry("V,W")] = ()
    """labeled course edge at which one row more is labeled"""
    rows: Annotated[int | None, help_entry("N", "all, and the mesh must be labeled completely")] = None
    """number of rows to label after those of the starts; the result is a partly labeled mesh"""
    picture: Annotated[str | None, help_entry("PNG", "none")] = None
    """picture of rows, wale directions, seams that do not match, unlabeled faces and faults"""
    found_rows: RowsSection = field(default_factory=RowsSection)
    panels: FoundPanels = field(default_factory=FoundPanels)
    overwrite: Overwrite = False

    def run(self) -> None:
        """Take the steps, and write the labeled or partly labeled mesh and the picture."""
        from stitchmesh.cli.output_folder import faults_drawn
        from stitchmesh.io import write_stitches
        from stitchmesh.io.contents import suffix_of
        from stitchmesh.io.stitches import TWO_WAY
        from stitchmesh.labeling.labeling_file import SUFFIXES, write_labeling

        suffix_of(self.output, TWO_WAY if self.rows is None else SUFFIXES)
        if self.picture is not None:
            suffix_of(self.picture, (".png",))
        labeling = self._found() if self.found_rows.auto else self._labeled(self._read())
        if self.rows is None:
            with faults_drawn(Path(self.output).parent):
                labeled = labeling.finish()
            write_stitches(self.output, labeled)
        else:
            write_labeling(self.output, labeling)
        self._draw(labeling)
        say(_summary(labeling))

    def _found(self) -> PartialLabeling:
        """Find rows of panels on the repaired mesh.

        Raises:
            ParameterError: an option is given that names edges or faces, or that is for stitches.
        """
        from stitchmesh.io.stitches import READABLE
        from stitchmesh.labeling import PartialLabeling
        from stitchmesh.pipeline.garment import whole_mesh
        from stitchmesh.shaping.auto_labels import auto_labels

        self._refuse_with_auto()
        if self.mesh.lower().endswith(READABLE):
            raise ParameterError("--auto: the mesh has rows already; give the polygon mesh")
        side = LabelSection(turn_inside_out=self.starts.turn_inside_out)
        found = self._recipe(side).read_mesh()
        for action in found.repairs or ():
            say(f"Repair: {action.text}: {action.places}.")
        options = self.found_rows.options(found.up)
        assert options is not None
        made = auto_labels(
            whole_mesh(found.mesh), marks=options.marks, up=options.up, multiple=options.multiple,
            **self.panels.arguments(),
        )  # fmt: skip
        return PartialLabeling.of_rows(made)

    def _recipe(self, side: LabelSection) -> Recipe:
        """Return a recipe for the reading of the mesh."""
        from stitchmesh.recipe.recipe import Recipe

        return Recipe(
            mesh=self.mesh, unit=self.in_file.unit, up=self.in_file.up, objects=self.in_file.objects,
            layer=self.in_file.layer, rows=self.found_rows, label=side,
        )  # fmt: skip

    def _refuse_with_auto(self) -> None:
        """Refuse options that name edges or faces of the given mesh, or that are for stitches.

        Raises:
            ParameterError: one of them is given.
        """
        rows, starts = self.found_rows, self.starts
        own = {"set edge": self.set_edge, "start border": starts.start_borders, "flip": starts.flip,
               "start edge": starts.start_edges, "row at": self.row_at, "rows": self.rows is not None}  # fmt: skip
        for words in (words for words, value in own.items() if value):
            raise ParameterError(
                f"{words}: is for the rows of a modelled mesh; find rows with --auto first, and give it for their file"
            )
        for words, given in (("no short rows", not rows.short_rows), ("most shaping", rows.most_shaping is not None),
                             ("shaping", rows.shaping != DEFAULT_PLACEMENT)):  # fmt: skip
            if given:
                raise ParameterError(f"{words}: is for stitches, and a panel holds many; give it to `knit --auto`")

    def _read(self) -> PartialLabeling:
        """Read the partly labeled mesh, or the mesh on which nothing is labeled."""
        from stitchmesh.io import read_stitches
        from stitchmesh.io.stitches import READABLE
        from stitchmesh.labeling import PartialLabeling, start_labeling
        from stitchmesh.labeling.label import warn_if_inside_out
        from stitchmesh.labeling.labeling_file import holds_labeling, read_labeling
        from stitchmesh.pipeline.garment import whole_mesh

        self.panels.refuse()
        recipe = self._recipe(self.starts)
        if self.mesh.lower().endswith(READABLE):
            for option, given in (("--turn-inside-out", self.starts.turn_inside_out), ("--up", self.in_file.up)):
                if given:
                    raise ParameterError(f"{option}: the mesh has rows already; turn the polygon mesh")
            if self.in_file.objects:
                raise ParameterError("--object: the mesh has rows already; choose from the polygon mesh")
            if holds_labeling(self.mesh):
                return read_labeling(self.mesh)
            return PartialLabeling.of_rows(read_stitches(self.mesh))
        mesh = whole_mesh(recipe.read_mesh().mesh)
        warn_if_inside_out(mesh)
        return start_labeling(mesh)

    def _labeled(self, labeling: PartialLabeling) -> PartialLabeling:
        """Take the steps in their order."""
        for edge, label in self.set_edge:
            labeling = labeling.set_edge(edge, label)  # type: ignore[arg-type]
        for edge in self.starts.start_borders:
            labeling = labeling.start_at_border(edge)
        for edge in self.starts.start_edges:
            labeling = labeling.start_at_edge(edge)
        for edge in self.row_at:
            labeling = labeling.label_row_at(edge)
        if self.rows is None:
            labeling = labeling.label_all()
        elif self.rows != 0:
            labeling = labeling.label_rows(self.rows)
        flips = self.starts.flip if self.rows is not None or labeling.labeled.all() else ()
        for face in flips:
            labeling = labeling.flip_row(face)
        return labeling

    def _draw(self, labeling: PartialLabeling) -> None:
        from stitchmesh.cli.output_folder import draw_if_possible

        if self.picture is not None:
            from stitchmesh.render.labeling_picture import render_labeling

            path = self.picture
            draw_if_possible(lambda: render_labeling(labeling, path))


def _summary(labeling: PartialLabeling) -> str:
    """One line on the rows, and one on the first fault if there are faults."""
    faces = labeling.mesh.face_count
    if labeling.labeled.all():
        return f"{labeling.row_count} rows of {faces} faces"
    lines = [f"{labeling.row_count} rows; {labeling.labeled.sum()} of {faces} faces labeled"]
    faults = labeling.faults
    if faults:
        lines.append(f"{sum(len(fault.faces) for fault in faults)} faces cannot be labeled; {faults[0].reason}")
    return "\n".join(lines)
