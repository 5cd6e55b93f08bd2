# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""An energy term that is not used loads and compiles nothing, and is not in the report."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import Mesh
from stitchmesh.simulation.dead_load import Gravity
from stitchmesh.yarnrelax import relax_yarns
from stitchmesh.yarnrelax.constraints.pins import Pins
from stitchmesh.yarnrelax.energies.body import Body
from stitchmesh.yarnrelax.energies.term import terms_and_constraints
from tests.gallery import ROOT
from tests.yarnrelax.stockinette import flat_patch

FLOOR = Mesh.from_polygons([[-9, -1, -9], [-9, -1, 9], [9, -1, 9], [9, -1, -9]], [[0, 1, 2, 3]])
OPTIONAL = ("body", "dead_load", "friction", "mesh_features", "pins", "point_load", "twist", "wind")
"""Beginnings of the names of files in ``yarnrelax`` that only some relaxations need."""
REPORT = """
import json, sys
import numpy as np
import warp as wp
from stitchmesh import Mesh, YarnSet, relax_yarns
from stitchmesh.yarnrelax.energies.body import Body
points = np.stack([np.arange(8.0), np.zeros(8), np.zeros(8)], axis=1)
yarns = YarnSet.from_curves([points], closed=[False], radius=0.3, rest_lengths=[np.full(5, 0.9)])
floor = Mesh.from_polygons([[-9, -9, -9], [-9, -9, 9], [9, -9, 9]], [[0, 1, 2]])
relax_yarns(yarns, quality="draft", device="cpu", terms=[Body(floor)])
loaded = [name for name in sys.modules if name.startswith(("stitchmesh.yarnrelax.", "stitchmesh.simulation."))]
kernels = [v for name in loaded for v in vars(sys.modules[name]).values() if isinstance(v, wp.Kernel)]
print(json.dumps([
    [name.split(".")[-1] for name in loaded],
    sorted({kernel.func.__module__.split(".")[-1] for kernel in kernels if kernel.overloads}),
]))
"""


def test_a_relaxation_compiles_only_the_kernels_that_it_needs() -> None:
    """The relaxation runs in a new interpreter, where no other test has loaded or compiled anything."""
    done = subprocess.run([sys.executable, "-c", REPORT], capture_output=True, text=True, check=True, cwd=ROOT)
    loaded, with_overloads = json.loads(done.stdout.splitlines()[-1])
    files = {"body", "body_surface", "body_penalty", "mesh_features"}
    assert {file for file in loaded if file.startswith(OPTIONAL)} == files
    # the modules shape and borders are loaded for the option ``keep_shape``, which is not used here
    assert {file for file in with_overloads if file.startswith((*OPTIONAL, "shape", "borders"))} == {"body"}
    assert {"segment_forces", "contact", "evaluation"} & set(with_overloads)  # compiled kernels are detected


def test_the_report_contains_the_energies_of_the_terms_and_no_others() -> None:
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
