# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The order of the stages from a mesh to relaxed yarns, and the driver that runs them.

``knit`` runs the table and keeps nothing, and a job keeps the value of each stage as a file.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh import StitchMesh
from stitchmesh.pipeline import stages
from stitchmesh.pipeline.garment import Garment, Made
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.quality import Quality, quality_named
from stitchmesh.run import Run
from stitchmesh.shaping.found_stitches import FoundStitches
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import Relaxation

T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class Stage(Generic[T]):
    """A step on the way from a mesh to relaxed yarns."""

    name: str
    """Name of the public function that does the work."""
    kind: type[T]
    """Class of the value that the stage makes."""
    make: Callable[[Garment, Run[Any]], Made[T]]
    """Makes the value in a run; relaxations obey all of the run, and other stages only its progress."""
    inputs: Callable[[Garment], tuple[object, ...]] = lambda garment: (garment.fabric,)
    """Values that decide the result besides the settings: the stitches so far, or other results of earlier stages."""
    settings: Callable[[KnitOptions], tuple[object, ...]] = lambda options: ()
    """The options that decide the value; a job passes options that hold the content of files in place of their
    paths."""
    asked: Callable[[Garment], bool] = lambda garment: True
    """Whether a garment asks for the stage."""

    def run(self, garment: Garment, run: Run[Any]) -> Made[T]:
        """Make the value.

        Raises:
            StitchMeshError: the stage cannot continue; a note of the error names the stage.
        """
        try:
            return self.make(garment, run)
        except StitchMeshError as error:
            error.add_note(f"The stage {self.name} of the garment has failed.")
            raise


Work = Callable[[Stage[Any], Garment], Made[Any]]
"""Function that provides the result of a stage for a garment: it runs the stage, or reads the kept result."""


def run_stages(table: Sequence[Stage[Any]], garment: Garment, work: Work) -> Garment:
    """Run the stages of a table that a garment asks for, one after another.

    Raises:
        StitchMeshError: a stage cannot continue.
    """
    for stage in table:
        if stage.asked(garment):
            garment = garment.after(stage.kind, work(stage, garment))
    return garment


def _processor(garment: Garment) -> str:
    """Return the kind of the device; results of two devices of one kind have the same bits."""
    return garment.device.partition(":")[0]


def _settings_of_found_rows(options: KnitOptions) -> tuple[object, ...]:
    return options.stitch_width, options.stitch_height, options.increase, options.shaping, options.panels


def _settings_of_patterns(options: KnitOptions) -> tuple[object, ...]:
    parts = [(part.pattern, part.remainder, part.ground, part.centre, str(part.on)) for part in options.patterns]
    return options.palette, parts


def _settings_of_mesh_relaxation(options: KnitOptions) -> tuple[object, ...]:
    if not options.finds_rows:
        return (options.mesh_relax_options,)
    sampling = quality_named(options.quality).control_points_per_stitch
    return options.mesh_relax_options, options.stitch_width, options.yarn_radius, sampling, options.finish


def _inputs_of_budget(garment: Garment) -> tuple[object, ...]:
    assert garment.budget is not None
    limits = garment.budget.within, garment.budget.error, garment.budget.chooses
    return garment.fabric, garment.device, limits


LABEL = Stage(
    name="label", kind=StitchMesh, make=stages.label_stage,
    asked=lambda garment: not garment.options.finds_rows,
    inputs=lambda garment: (garment.mesh,),
    settings=lambda options: (options.borders, options.seeds, options.flip),
)  # fmt: skip
AUTO_STITCHES = Stage(
    name="auto_stitches", kind=FoundStitches, make=stages.auto_stitches_stage,
    asked=lambda garment: garment.options.shaping is not None,
    inputs=lambda garment: (garment.mesh,),
    settings=_settings_of_found_rows,
)  # fmt: skip
SHAPE_PANELS = Stage(
    name="shape_panels", kind=FoundStitches, make=stages.shape_panels_stage,
    asked=lambda garment: garment.options.panels is not None,
    inputs=lambda garment: (garment.mesh,),
    settings=_settings_of_found_rows,
)  # fmt: skip
TESSELLATE = Stage(
    name="tessellate", kind=StitchMesh, make=stages.tessellate_stage,
    asked=lambda garment: not garment.options.finds_rows,
    settings=lambda options: (
        options.stitch_width, options.stitch_height, options.counts, options.marked, options.increase,
    ),
)  # fmt: skip
APPLY_PATTERN = Stage(
    name="apply_pattern", kind=StitchMesh, make=stages.apply_pattern_stage,
    asked=lambda garment: bool(garment.options.palette or garment.options.patterns),
    settings=_settings_of_patterns,
)  # fmt: skip
APPLY_EDIT = Stage(
    name="apply_edit", kind=StitchMesh, make=stages.apply_edit_stage,
    asked=lambda garment: bool(garment.options.edits),
    settings=lambda options: (options.edits,),
)  # fmt: skip
RELAX_MESH = Stage(
    name="relax_mesh", kind=StitchMesh, make=stages.relax_mesh_stage,
    inputs=lambda garment: (garment.fabric, garment.surface, garment.found, _processor(garment)),
    settings=_settings_of_mesh_relaxation,
)  # fmt: skip
EDGE_FORMS = Stage(
    name="edge_forms", kind=StitchMesh, make=stages.edge_forms_stage,
    asked=lambda garment: bool(garment.options.edge_forms),
    settings=lambda options: (options.edge_forms, options.yarn_radius),
)  # fmt: skip
MAKE_SPIRAL = Stage(
    name="make_spiral", kind=StitchMesh, make=stages.make_spiral_stage,
    asked=lambda garment: garment.options.spiral,
)  # fmt: skip
BUDGET = Stage(
    name="budget", kind=Quality, make=stages.budget_stage,
    asked=lambda garment: garment.budget is not None,
    inputs=_inputs_of_budget,
    settings=lambda options: (quality_named(options.quality),),
)  # fmt: skip
GENERATE_YARNS = Stage(
    name="generate_yarns", kind=YarnSet, make=stages.generate_yarns_stage,
    inputs=lambda garment: (garment.fabric, garment.quality.control_points_per_stitch),
    settings=lambda options: (
        options.yarn_radius, options.drawn_radius, options.mass_per_length, options.yarn, options.finish,
    ),
)  # fmt: skip
RELAX_YARNS = Stage(
    name="relax_yarns", kind=Relaxation, make=stages.relax_yarns_stage,
    inputs=lambda garment: (garment.fabric, garment.yarns, garment.quality, _processor(garment)),
    settings=lambda options: (options.relaxation,),
)  # fmt: skip

ROWS = (LABEL, AUTO_STITCHES, SHAPE_PANELS)
"""Stages that find the rows of a mesh; a garment asks for one of them."""
STITCHES = (TESSELLATE, APPLY_PATTERN, APPLY_EDIT, RELAX_MESH, EDGE_FORMS, MAKE_SPIRAL)
"""Stages from the rows to the stitches for which yarns are generated."""
YARNS = (BUDGET, GENERATE_YARNS)
"""Stages from the stitches to the yarns that ``RELAX_YARNS`` relaxes."""
