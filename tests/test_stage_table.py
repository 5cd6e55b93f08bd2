# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The table of the stages: which a garment asks for, and what decides their values."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import pytest

from stitchmesh.editing.edge_forms import EdgeForm
from stitchmesh.editing.edit import Edit
from stitchmesh.editing.pattern_regions import PatternRegion
from stitchmesh.errors import ParameterError
from stitchmesh.meshrelax import MeshRelaxOptions
from stitchmesh.patterns import parse_pattern
from stitchmesh.pipeline.garment import Garment, Made
from stitchmesh.pipeline.options import KnitOptions, RelaxOptions
from stitchmesh.pipeline.stage_table import LABEL, RELAX_YARNS, ROWS, STITCHES, YARNS, Stage, run_stages
from stitchmesh.run import QUIET
from stitchmesh.shaping.options import ShapingOptions
from stitchmesh.shaping.panels.options import PanelOptions
from stitchmesh.yarn.yarn_presets import Yarn
from stitchmesh.yarngen import YarnFinish
from tests.gallery import grid

STAGES = (*ROWS, *STITCHES, *YARNS, RELAX_YARNS)
OTHER: dict[str, Any] = {
    "stitch_width": 0.7, "stitch_height": 0.6, "counts": {(0, 1): 5}, "marked": ((0, 1),), "increase": "kfb",
    "mesh_relaxation": MeshRelaxOptions(alpha=0.8), "yarn_radius": 0.1, "drawn_radius": 0.2, "mass_per_length": 0.01,
    "yarn": Yarn.named("dk"),
    "borders": (1,), "seeds": (1,), "flip": (0,), "shaping": ShapingOptions(multiple=4), "panels": PanelOptions(),
    "palette": ("navy",), "patterns": (PatternRegion(parse_pattern("row 1 RS: k, p")),),
    "edits": (Edit("stripes", {"bands": "2 navy"}),), "edge_forms": (EdgeForm("hem", "fold", 4),), "spiral": True,
    "finish": YarnFinish(cast_on="open"), "relaxation": RelaxOptions(material="leaf"), "quality": "draft",
}  # fmt: skip
"""Another value of each option that decides bits; the processor decides by its kind, as an input of stages."""


def decided_by(options: KnitOptions) -> list[tuple[object, ...]]:
    """What decides the values of the stages that options ask for, beside the values of other stages."""
    garment = Garment(mesh=grid(2, 2), options=options)
    return [(stage.name, stage.settings(options), garment.quality) for stage in STAGES if stage.asked(garment)]


@pytest.mark.parametrize("name", [field.name for field in fields(KnitOptions) if field.name != "device"])
def test_every_option_decides_the_value_of_a_stage(name: str) -> None:
    """A job would otherwise take the kept value of other options for its own."""
    assert decided_by(replace(KnitOptions(), **{name: OTHER[name]})) != decided_by(KnitOptions())


def test_plain_options_ask_for_the_plain_stages() -> None:
    garment = Garment(mesh=grid(2, 2), options=KnitOptions())
    asked = [stage.name for stage in STAGES if stage.asked(garment)]
    assert asked == ["label", "tessellate", "relax_mesh", "generate_yarns", "relax_yarns"]


def test_the_driver_gives_each_stage_the_values_and_the_report_of_those_before() -> None:
    seen: list[tuple[str, list[str]]] = []

    def work(stage: Stage[Any], garment: Garment) -> Made[Any]:
        seen.append((stage.name, list(garment.report)))
        return Made(garment.quality, {stage.name: 1})

    run_stages(STAGES, Garment(mesh=grid(2, 2), options=KnitOptions(spiral=True), report={"head": 1}), work)
    assert seen[-1] == ("relax_yarns", ["head", "label", "tessellate", "relax_mesh", "make_spiral", "generate_yarns"])


def test_an_error_names_its_stage() -> None:
    garment = Garment(mesh=grid(2, 2), options=KnitOptions(seeds=(999,)))
    with pytest.raises(ParameterError) as refused:
        LABEL.run(garment, QUIET)
    assert refused.value.__notes__ == ["The stage label of the garment has failed."]
