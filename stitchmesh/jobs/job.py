# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A job as a value: what is made, by which stages with which options, and what is written.

A job holds names, numbers and paths only. It makes a garment from a mesh or from a recipe, or one repeat of a pattern.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import MISSING, dataclass, field, fields, replace
from pathlib import Path

from stitchmesh.budget.budget import Budget
from stitchmesh.editing.edit import Edit
from stitchmesh.errors import ParameterError
from stitchmesh.io.stitches import WRITABLE as STITCH_SUFFIXES
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.io.yarns import FORMATS
from stitchmesh.jobs.sections import (
    AutoStitchesTable,
    GenerateYarnsTable,
    LabelTable,
    RelaxYarnsTable,
    RenderTable,
    SwatchTable,
    TessellateTable,
)
from stitchmesh.mesh.layers import Layer
from stitchmesh.meshrelax.options import MeshRelaxOptions
from stitchmesh.quality import DEFAULT_QUALITY, quality_named
from stitchmesh.recipe.recipe import Recipe, RecipePattern
from stitchmesh.recipe.sections import (
    LabelSection,
    MaterialSection,
    RestLengthsSection,
    RowsSection,
    SolverSection,
    StitchesSection,
)
from stitchmesh.yarngen.finish import YarnFinish

SOURCES = ("mesh", "recipe", "swatch")
"""Keys that say what a job makes; each job has one of them."""
OF_MESHES = (
    "unit", "up", "objects", "layer", "turn_inside_out", "label", "tessellate", "auto_stitches", "apply_pattern",
    "apply_edit", "relax_mesh", "make_spiral", "generate_yarns", "apply_rest_lengths",
)  # fmt: skip
"""Keys that only a job from a mesh has: a recipe has its own, and a swatch has no such stages."""
OF_GARMENTS = ("relax_yarns", "write_stitches")
"""Keys that a swatch does not have."""


@dataclass(frozen=True, kw_only=True)
class Job:
    """What is made from a mesh, from a recipe or from a pattern.

    Paths of what is read are relative to the present folder; ``read_job`` makes them so.

    Raises:
        ParameterError: there is not exactly one source, a key does not belong to the source, a name or an amount is not
            accepted, or the name of an output is not that of a file in the folder of the job.
    """

    mesh: str | None = None
    """Path of a polygon mesh."""
    unit: str = DEFAULT_UNIT
    """Unit of a mesh file that states no unit."""
    up: tuple[float, float, float] | None = None
    """Direction in the coordinates of the mesh file that points up; None if the file or the shape of the mesh tells."""
    objects: tuple[str, ...] = ()
    """Names of objects or groups of the mesh file that are knitted; none for all that can be garments."""
    layer: Layer = "outer"
    """Layer of a garment with a thickness that is knitted: outer, inner or middle."""
    turn_inside_out: bool = False
    """Whether all faces of the mesh are reversed first."""
    recipe: str | None = None
    """Path of the recipe of a garment."""
    quality: str | None = None
    """Preset of accuracy and cost; None for that of the recipe, ``standard``, or the choice of the budget."""
    device: str | None = None
    """Processor, ``cpu`` or ``cuda:0``; None for the first GPU, or the CPU without a GPU."""
    within: str | None = None
    """Time for the whole job, such as ``8h``."""
    error: str | None = None
    """Largest relative error of the stitch spacing, such as ``1%``."""
    label: LabelTable = field(default_factory=LabelTable)
    tessellate: TessellateTable = field(default_factory=TessellateTable)
    auto_stitches: AutoStitchesTable | None = None
    """How rows are found on a repaired mesh of any kind, in the place of ``label`` and ``tessellate``."""
    apply_pattern: tuple[RecipePattern, ...] = ()
    """Patterns, each on its part of the garment."""
    apply_edit: tuple[Edit, ...] = ()
    """Edits that are applied one after another, after the patterns."""
    relax_mesh: MeshRelaxOptions = field(default_factory=MeshRelaxOptions)
    make_spiral: bool = False
    """Whether tubes are knitted in one spiral row."""
    generate_yarns: GenerateYarnsTable = field(default_factory=GenerateYarnsTable)
    apply_rest_lengths: RestLengthsSection = field(default_factory=RestLengthsSection)
    relax_yarns: RelaxYarnsTable = field(default_factory=RelaxYarnsTable)
    swatch: SwatchTable | None = None
    """One repeat of a pattern or weave in the place of a garment."""
    write_stitches: tuple[str, ...] = ("stitches.h5",)
    """Files of the stitch mesh, in the folder of the job."""
    write_yarns: tuple[str, ...] = ("yarns.h5", "yarns.bcc")
    """Files of the relaxed yarns, in the folder of the job."""
    render: tuple[RenderTable, ...] = (RenderTable(),)
    """Pictures of the relaxed yarns."""

    def __post_init__(self) -> None:
        given = [name for name in SOURCES if getattr(self, name) is not None]
        if len(given) != 1:
            found = " and ".join(given) or "none of them"
            raise ParameterError(f"job: got {found}; expected one of mesh, recipe and [swatch]")
        others = {"mesh": (), "recipe": OF_MESHES, "swatch": (*OF_MESHES, *OF_GARMENTS)}[given[0]]
        remedy = f"write it into {self.recipe}" if given[0] == "recipe" else "leave it out"
        self._refuse(others, f"a job with a {given[0]}; {remedy}")
        if self.auto_stitches is not None:
            self._refuse(("label", "tessellate"), "a job with auto_stitches, which finds rows itself; leave it out")
        if self.quality is not None:
            quality_named(self.quality)
        _check_outputs("write_stitches", self.write_stitches, STITCH_SUFFIXES)
        _check_outputs("write_yarns", self.write_yarns, FORMATS)
        _check_outputs("render", [picture.path for picture in self.render], (".png",))
        for picture in self.render:
            picture.options()
        if self.budget is not None:
            self.budget.refuse_kept_quality(kept=self.quality is not None)

    def _refuse(self, others: Iterable[str], reason: str) -> None:
        """Return unless one of some keys has another value than its default."""
        for part in fields(self):
            default = part.default if part.default_factory is MISSING else part.default_factory()
            if part.name in others and getattr(self, part.name) != default:
                raise ParameterError(f"{part.name}: is no key of {reason}")

    @property
    def budget(self) -> Budget | None:
        """The limits on the time and on the error of the whole job; None without limits."""
        return Budget.of(self.within, self.error)


def recipe_of(job: Job) -> Recipe:
    """Return the recipe of a job that makes a garment, with the quality and the device of the job.

    Raises:
        FileError: the recipe cannot be read (``read_recipe``).
    """
    if job.recipe is not None:
        from stitchmesh.recipe.recipe_file import read_recipe

        recipe, default = read_recipe(job.recipe), RelaxYarnsTable()
        if replace(job.relax_yarns, checkpoint_every=default.checkpoint_every) != default:
            raise ParameterError(f"relax_yarns: a recipe has all but checkpoint_every; write it into {job.recipe}")
        return replace(recipe, quality=job.quality or recipe.quality, device=job.device or recipe.device)
    assert job.mesh is not None
    yarns, relax = job.generate_yarns, job.relax_yarns
    found, size = job.auto_stitches, job.auto_stitches or job.tessellate
    finish = YarnFinish(yarns.bind_off, yarns.cast_on, yarns.longest_float)
    return Recipe(
        mesh=job.mesh,
        unit=job.unit,
        up=job.up,
        objects=job.objects,
        layer=job.layer,
        stitch_width=size.stitch_width,
        yarn_radius=yarns.yarn_radius,
        drawn_radius=yarns.drawn_radius,
        mass_per_length=yarns.mass_per_length,
        quality=job.quality or DEFAULT_QUALITY,
        device=job.device,
        spiral=job.make_spiral,
        patterns=job.apply_pattern,
        edits=job.apply_edit,
        rows=RowsSection() if found is None else found.rows(),
        label=LabelSection(
            start_borders=job.label.borders, start_edges=job.label.seeds, flip=job.label.flip,
            turn_inside_out=job.turn_inside_out,
        ),
        stitches=StitchesSection(
            course_height=size.stitch_height, increase=size.increase, counts=job.tessellate.counts,
            marked=job.tessellate.marked,
        ),
        mesh_relaxation=job.relax_mesh,
        finish=finish,
        material=MaterialSection(name=relax.material, stiffness=relax.stiffness),
        rest_lengths=job.apply_rest_lengths,
        physics=relax.physics,
        solver=SolverSection(method=relax.solver, max_iterations=relax.max_iterations),
    )  # fmt: skip


def _check_outputs(key: str, names: Iterable[str], suffixes: Iterable[str]) -> None:
    """Return if each name is that of a file in the folder of the job, with a known suffix."""
    known = tuple(suffixes)
    for name in names:
        if Path(name).name != name or name.startswith(".") or Path(name).suffix.lower() not in known:
            suffix = f"with one of the suffixes {' '.join(known)}"
            raise ParameterError(f"{key}: got {name!r}; expected a file in the folder of the job, {suffix}")
