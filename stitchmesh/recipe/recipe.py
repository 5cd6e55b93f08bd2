# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A recipe: everything that decides a garment, as a value.

A recipe holds names, numbers and paths only. ``recipe_options`` reads the patterns and returns the options of the
pipeline.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from stitchmesh.editing.edge_forms import parse_edge_form
from stitchmesh.editing.edit import Edit
from stitchmesh.editing.on_selection import ON
from stitchmesh.editing.pattern_regions import PatternRegion
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.io.yarn_files import yarn_of
from stitchmesh.mesh.palette import STOCK, colour_text, make_palette, parse_colour
from stitchmesh.mesh.upright import Direction, Y
from stitchmesh.patterns import read_pattern
from stitchmesh.patterns.moved import mirrored_pattern, shifted_pattern
from stitchmesh.patterns.placement.columns import check_remainder
from stitchmesh.pipeline.options import KnitOptions, RelaxOptions
from stitchmesh.quality import DEFAULT_QUALITY
from stitchmesh.recipe.sections import GarmentSettings, MaterialSection, PhysicsSection, RecipeColour, RecipePattern
from stitchmesh.selection import parse_selection
from stitchmesh.tessellate import STITCH_WIDTH
from stitchmesh.yarn.rest_length import RestLengths
from stitchmesh.yarnrelax.model.material import NAMED, YarnMaterial

if TYPE_CHECKING:
    from stitchmesh.mesh import Mesh
    from stitchmesh.mesh.repair import RepairAction
    from stitchmesh.shaping.panels.panel_mesh import PanelMesh

logger = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class RecipeMesh:
    """The mesh of a recipe, from its file."""

    mesh: Mesh | PanelMesh
    """The mesh or the panels [cm], with y up."""
    up: Direction
    """Direction in the coordinates of the file that points up."""
    repairs: tuple[RepairAction, ...] | None
    """What a repair has changed; None if the mesh was not repaired."""


@dataclass(frozen=True, kw_only=True)
class Recipe(GarmentSettings):
    """How a garment is made from a mesh.

    Paths are relative to the present folder; ``read_recipe`` makes them so.
    """

    mesh: str
    """Path of the polygon mesh."""
    quality: str = DEFAULT_QUALITY
    """Preset of accuracy and cost."""
    device: str | None = None
    """Processor, ``cpu`` or ``cuda:0``; None for the first GPU, or the CPU without a GPU."""
    patterns: tuple[RecipePattern, ...] = ()
    """Patterns, each on its part of the garment."""
    edits: tuple[Edit, ...] = ()
    """Edits that are applied one after another, after the patterns."""
    colours: tuple[RecipeColour, ...] = ()
    """Colours of parts of the garment, set one after another, after the edits."""

    def read_mesh(self) -> RecipeMesh:
        """Read the mesh, with y up; if rows are found on it, make a valid mesh of polygons of any kind, or panels.

        A warning says which choices were made where the file states nothing.

        Raises:
            StitchMeshError: as for ``read_garment`` or ``read_panels``.
        """
        from stitchmesh.io.garments import read_garment
        from stitchmesh.mesh.orientation import turn_inside_out

        # A given direction of knitting refers to the mesh before it is turned.
        up = Y if self.up is None and self.rows.up != Y else self.up
        if self.panels.knit:
            return self._read_panels(up)
        found = read_garment(self.mesh, replace(self, up=up), repaired=self.rows.auto)
        self._warn(*found.notes)
        mesh = turn_inside_out(found.mesh) if self.label.turn_inside_out else found.mesh
        return RecipeMesh(mesh, found.up, found.repairs)

    def _read_panels(self, up: Direction | None) -> RecipeMesh:
        """Read the panels of a sewing pattern; ``up`` is None if their openings decide which direction points up."""
        from stitchmesh.io.garments import doubt_of_unit, found_up
        from stitchmesh.io.meshes import read_repaired_mesh
        from stitchmesh.shaping.panels.read_panels import read_panels

        if self.objects:
            raise ParameterError("objects: are panels of a sewing pattern; leave --object out")
        panels = read_panels(self.mesh, unit=self.unit)
        self._warn(doubt_of_unit(self.mesh, panels.mesh, self.unit))
        if up is None:  # Panels have borders at their seams, where the whole garment has none.
            up, said = found_up(self.mesh, read_repaired_mesh(self.mesh, unit=self.unit).mesh)
            self._warn(said)
        if up != Y:
            panels = read_panels(self.mesh, unit=self.unit, up=up)
        return RecipeMesh(panels.turned_inside_out() if self.label.turn_inside_out else panels, up, None)

    def _warn(self, *notes: str) -> None:
        """Warn of choices that the file of the mesh leaves open."""
        for note in filter(None, notes):
            logger.warning(f"{self.mesh}: {note}")


def recipe_options(recipe: Recipe, up: Direction = Y) -> KnitOptions:
    """Read all files that a recipe names, except for the mesh, and return the options of the pipeline.

    Args:
        recipe: the recipe.
        up: direction in the coordinates of the mesh file that points up; marks and the body are turned with the mesh.

    Raises:
        ParameterError: a name or a number is not accepted; the message names the part of the recipe.
        FileError: a file cannot be read.
        PatternError: a file does not describe a valid pattern.
    """
    size, edges = recipe.size, recipe.stitches.edge_settings()
    palette, stripes = _colours(recipe)
    return KnitOptions(
        stitch_width=STITCH_WIDTH if size.stitch_width is None else size.stitch_width,
        stitch_height=size.stitch_height,
        counts=edges.counts,
        marked=edges.marked,
        increase=recipe.stitches.increase,
        mesh_relaxation=recipe.mesh_relaxation,
        yarn_radius=size.yarn_radius,
        drawn_radius=size.drawn_radius,
        mass_per_length=size.mass_per_length,
        yarn=None if recipe.yarn is None else yarn_of(recipe.yarn),
        quality=recipe.solver.quality(recipe.quality),
        device=recipe.device,
        borders=recipe.label.start_borders,
        seeds=recipe.label.start_edges,
        flip=recipe.label.flip,
        shaping=recipe.rows.options(up),
        panels=recipe.panels.options(recipe.rows.shaping),
        palette=palette,
        patterns=pattern_regions(recipe),
        edits=(*recipe.edits, *stripes),
        edge_forms=tuple(map(parse_edge_form, recipe.edge_forms)),
        spiral=recipe.spiral,
        finish=recipe.finish,
        relaxation=relax_options(
            recipe.material, recipe.physics, recipe.rest_lengths.rest_lengths(size.loop_length), up, yarn=recipe.yarn
        ),
    )


def relax_options(
    material: MaterialSection, physics: PhysicsSection, rest_lengths: RestLengths, up: Direction = Y,
    yarn: str | None = None,
) -> RelaxOptions:  # fmt: skip
    """Return the options of the relaxation of yarns.

    Args:
        material: material of the yarn.
        physics: additional energies.
        rest_lengths: changes of the rest lengths.
        up: direction that points up in the file of a body whose format does not fix it.
        yarn: name of the yarn, or path of its description.

    Raises:
        FileError: the body cannot be read.
        ParameterError: a name or a number is not accepted.
    """
    name = material.name or yarn
    return RelaxOptions(
        # the values of a yarn and not its name, so that a stage is made again when its description changes
        material=name if name is None or name in NAMED else YarnMaterial.named(name), stiffness=material.values(),
        rest_lengths=rest_lengths, terms=tuple(physics.terms(up)),
    )  # fmt: skip


def pattern_regions(recipe: Recipe) -> tuple[PatternRegion, ...]:
    """Read the patterns of a recipe.

    Raises:
        ParameterError, FileError, PatternError: as for ``recipe_options``.
    """
    return tuple(_region(part, number) for number, part in enumerate(recipe.patterns))


def _region(part: RecipePattern, number: int) -> PatternRegion:
    try:
        on = None if part.on is None else parse_selection(part.on)
        pattern = mirrored_pattern(read_pattern(part.pattern)) if part.mirror else read_pattern(part.pattern)
        moved = shifted_pattern(pattern, *part.shift)
        return PatternRegion(moved, on, check_remainder(part.remainder), part.ground, part.centre)
    except StitchMeshError as error:
        raise type(error)(f"patterns[{number}]: {error}") from error


def _colours(recipe: Recipe) -> tuple[tuple[str, ...], list[Edit]]:
    """Return the palette, and the edits that set the yarns of parts of the garment."""
    try:
        colours = [colour_text(colour) for colour in make_palette(recipe.palette)]
    except ParameterError as error:
        raise ParameterError(f"palette: {error}") from error
    stripes = []
    for number, part in enumerate(recipe.colours):
        try:
            parse_selection(part.on)
            yarn = part.yarn if part.colour is None else _yarn_of(colours, colour_text(parse_colour(part.colour)))
        except ParameterError as error:
            raise ParameterError(f"colours[{number}]: {error}") from error
        stripes.append(Edit("stripe", {ON: part.on, "yarn": yarn}))
    return tuple(colours), stripes


def _yarn_of(colours: list[str], colour: str) -> int:
    """Return the number of a colour in a palette; a new colour is added, after the stock colour of yarn 0."""
    if colour not in colours:
        colours += [colour] if colours else [colour_text(STOCK[0]), colour]
    return colours.index(colour)
