# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""An energy term that is not used launches no kernel, allocates no memory and compiles nothing."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import Mesh
from stitchmesh.quality import quality_named
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.collision.narrow_phase import make_candidates
from stitchmesh.yarnrelax.constraints.pins import Pins
from stitchmesh.yarnrelax.energies import evaluation
from stitchmesh.yarnrelax.energies.body import Body
from stitchmesh.yarnrelax.energies.gravity import Gravity
from stitchmesh.yarnrelax.energies.point_load import PointLoad
from stitchmesh.yarnrelax.energies.term import ConstraintChoice, TermChoice, terms_and_constraints
from stitchmesh.yarnrelax.model.state import make_state
from stitchmesh.yarnrelax.model.upload import put_model
from stitchmesh.yarnrelax.simulation import YarnSimulation
from tests.gallery import ROOT
from tests.nightly import mostly_at_night
from tests.yarnrelax.stockinette import flat_patch

FLOOR = Mesh.from_polygons([[-9, -1, -9], [-9, -1, 9], [9, -1, 9], [9, -1, -9]], [[0, 1, 2, 3]])
OPTIONAL = ("body", "friction", "gravity", "mesh_features", "pins", "point_load", "twist")
"""Beginnings of the names of files in ``yarnrelax`` that only some relaxations need."""


def kernels_of_forces(*choices: TermChoice) -> list[str]:
    """Names of the kernels that ``force_launches`` launches, in order."""
    model = put_model(
        flat_patch(1, 2), YarnMaterial.named("leaf"), quadrature_points=3, contact_samples=3, scalar=wp.float32,
        device=device_named("cpu"),
    )  # fmt: skip
    launched: list[str] = []

    def count(kernel: wp.Kernel, *arguments: Any, **options: Any) -> None:
        launched.append(kernel.key.split("__")[0])

    terms = [choice.on(model) for choice in choices]
    state, candidates = make_state(model, external=bool(terms)), make_candidates(model, 0.1)
    evaluation.force_launches(model, state, candidates, terms, model.empty(model.point_count), count)
    return launched


def test_forces_without_additional_terms_need_three_kernels() -> None:
    launched = kernels_of_forces()
    assert launched[1:] == ["contact_forces", "gather_forces"]
    assert launched[0].startswith("samples_and_segment_forces")


@pytest.mark.parametrize(
    ("choices", "added"),
    [
        ([Gravity()], ["add_weights"]),
        ([Body(FLOOR)], ["body_forces"]),
        ([PointLoad((0.0, 1.0, 0.0), [3])], ["add_point_load"]),
        ([Gravity(), Body(FLOOR)], ["add_weights", "body_forces"]),
    ],
)
def test_each_term_adds_one_kernel(choices: list[TermChoice], added: list[str]) -> None:
    place, contact, gather = kernels_of_forces()
    # with at least one additional term, a launch first sets the external forces to zero
    assert kernels_of_forces(*choices) == [place, contact, "clear_vectors", *added, gather]


def launches_of_an_iteration(terms: list[TermChoice], constraints: list[ConstraintChoice]) -> int:
    simulation = YarnSimulation.start(
        flat_patch(1, 2), YarnMaterial.named("leaf"), quality_named("draft"), device_named("cpu"), terms, constraints
    )
    return len(simulation.iterations.launches)


def test_an_iteration_has_the_launches_of_its_terms_and_constraints_only() -> None:
    bare = launches_of_an_iteration([], [])
    assert launches_of_an_iteration([], [Pins([0])]) == bare + 2  # one launch filters the forces, one the steps
    assert launches_of_an_iteration([Gravity()], []) == bare + 2  # clear external forces, add weights
    assert launches_of_an_iteration([Gravity(), Body(FLOOR)], [Pins([0])]) == bare + 5


def test_a_state_without_terms_allocates_no_external_forces() -> None:
    model = put_model(
        flat_patch(1, 2), YarnMaterial.named("leaf"), quadrature_points=3, contact_samples=3, scalar=wp.float32,
        device=device_named("cpu"),
    )  # fmt: skip
    assert len(make_state(model).external_force) == 0


REPORT = """
import json, sys
import numpy as np
import warp as wp
from stitchmesh import Mesh, YarnSet, relax_yarns
points = np.stack([np.arange(8.0), np.zeros(8), np.zeros(8)], axis=1)
yarns = YarnSet.from_curves([points], closed=[False], radius=0.3, rest_lengths=[np.full(5, 0.9)])
{choice}
relax_yarns(yarns, quality="draft", device="cpu", terms=[*terms, *constraints])
loaded = [name for name in sys.modules if name.startswith("stitchmesh.yarnrelax.")]
kernels = [v for name in loaded for v in vars(sys.modules[name]).values() if isinstance(v, wp.Kernel)]
print(json.dumps([
    [name.split(".")[-1] for name in loaded],
    sorted({{kernel.func.__module__.split(".")[-1] for kernel in kernels if kernel.overloads}}),
]))
"""
CHOICES = {
    "nothing": ("terms = constraints = []", set(), set()),
    "gravity": (
        "from stitchmesh.yarnrelax.energies.gravity import Gravity; terms, constraints = [Gravity()], []",
        {"gravity"},
        {"gravity"},
    ),
    "pins": (
        "from stitchmesh.yarnrelax.constraints.pins import Pins; terms, constraints = [], [Pins([0])]",
        {"pins"},
        {"pins"},
    ),
    "point load": (
        "from stitchmesh.yarnrelax.energies.point_load import PointLoad; constraints = []; "
        "terms = [PointLoad((1.0, 0.0, 0.0), [0])]",
        {"point_load"},
        {"point_load"},
    ),
    "friction": (
        "from stitchmesh.yarnrelax.friction.friction import Friction; terms, constraints = [Friction(0.3)], []",
        {"friction", "friction_contacts", "friction_law"},
        {"friction", "friction_contacts"},
    ),
    "body": (
        "from stitchmesh.yarnrelax.energies.body import Body; constraints = []; "
        "terms = [Body(Mesh.from_polygons([[-9, -1, -9], [-9, -1, 9], [9, -1, 9]], [[0, 1, 2]]))]",
        {"body", "body_surface", "body_penalty", "body_stiffness", "mesh_features"},
        {"body"},
    ),
}


@pytest.mark.parametrize("name", mostly_at_night(CHOICES, by_day=("nothing", "body")))
def test_a_relaxation_compiles_only_the_kernels_that_it_needs(name: str) -> None:
    """The relaxation runs in a new interpreter, where no other test has loaded or compiled anything."""
    choice, files, compiled = CHOICES[name]
    done = subprocess.run(
        [sys.executable, "-c", REPORT.format(choice=choice)], capture_output=True, text=True, check=True, cwd=ROOT
    )
    loaded, with_overloads = json.loads(done.stdout.splitlines()[-1])
    assert {file for file in loaded if file.startswith(OPTIONAL)} == files
    # the modules shape and borders are loaded for the option ``keep_shape``, which is not used here
    assert {file for file in with_overloads if file.startswith((*OPTIONAL, "shape", "borders"))} == compiled
    assert {"segment_forces", "contact", "evaluation"} & set(with_overloads)  # compiled kernels are detected


def test_the_report_contains_the_energies_of_the_terms_and_no_others() -> None:
    from stitchmesh.yarnrelax import relax_yarns

    yarns = flat_patch(1, 2)
    pins = Pins(np.arange(len(yarns.points)))
    bare = relax_yarns(yarns, quality="draft", device="cpu", terms=[pins]).report["energies"]
    more = relax_yarns(yarns, quality="draft", device="cpu", terms=[Gravity(), Body(FLOOR), pins])
    assert list(more.report["energies"]) == [*bare, "gravity", "body"]


def test_what_neither_acts_nor_constrains_is_refused() -> None:
    pins = Pins([0])
    assert terms_and_constraints([pins, Gravity()]) == ([Gravity()], [pins])
    with pytest.raises(ParameterError, match=r"terms: got 3; expected energies, such as Gravity\(\), and constraints"):
        terms_and_constraints([Gravity(), 3])  # type: ignore[list-item]
