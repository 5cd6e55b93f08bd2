# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Measures of labeled meshes, and meshes scaled to other measures."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.io import read_mesh
from stitchmesh.labeling import label
from stitchmesh.recipe.garment_measures import GarmentMeasures
from tests.gallery import ROOT, tube


def measures_of(name: str) -> GarmentMeasures:
    return GarmentMeasures(label(read_mesh(ROOT / "assets" / "meshes" / f"{name}.obj")))


def test_a_cylinder_has_the_measures_of_its_polygon_and_is_scaled_exactly():
    measures = GarmentMeasures(label(tube(8, 3, radius=5.0, height=4.0)))
    girth = 16 * 5.0 * math.sin(math.pi / 8)
    assert measures.value("girth") == pytest.approx(girth) and measures.value("length") == pytest.approx(12.0)
    scaled = measures.scaled({"girth": 1.3 * girth, "length": 9.0})
    expected = measures.labeled.vertices * (1.3, 0.75, 1.3)
    # The corrections end at a relative error of 1e-4, which is 12 um of 12 cm.
    assert np.abs((scaled.vertices - scaled.vertices.mean(axis=0)) - (expected - expected.mean(axis=0))).max() < 1.2e-3


def test_the_hat_is_scaled_about_its_axis():
    measures = measures_of("hat")
    wanted = {"head": 1.2 * measures.value("head"), "length": 0.9 * measures.value("length")}
    scaled = measures.scaled(wanted).vertices
    expected = measures.labeled.vertices * (1.2, 0.9, 1.2)
    # All rings have nearly the same axis, so that the scaling is nearly that of a cylinder: within 3 mm of 25 cm.
    assert np.abs((scaled - scaled.mean(axis=0)) - (expected - expected.mean(axis=0))).max() < 0.3


@pytest.mark.parametrize(("name", "wanted"), [
    ("sweater", {"chest": 120.0, "length": 68.0, "sleeve length": 48.0, "upper arm": 47.0, "wrist": 22.0}),
    ("sock", {"foot": 23.0, "foot length": 27.0, "leg length": 24.0}),
    ("dress", {"bust": 100.0, "waist": 84.0, "hem": 150.0, "length": 92.0}),
    ("glove", {"hand": 22.0, "length": 24.0}),
])  # fmt: skip
def test_a_garment_gets_several_measures_together(name, wanted):
    measures = measures_of(name)
    scaled = measures.scaled(wanted)
    for measure, value in wanted.items():
        assert measures.value(measure, scaled) == pytest.approx(value, rel=1e-4), measure  # NEAR
    assert (scaled.face_start == measures.labeled.face_start).all()


def test_what_no_measure_names_keeps_its_size():
    measures = measures_of("sweater")
    longer = measures.scaled({"sleeve length": 50.0})
    for name in ("chest", "hem", "neck", "length", "upper arm"):
        # Rows beside the sleeves move a little, because the field is smooth.
        assert measures.value(name, longer) == pytest.approx(measures.value(name), rel=0.02), name
    same = measures.scaled({"chest": measures.value("chest")})
    assert np.abs(same.vertices - measures.labeled.vertices).max() < 1e-9


def test_a_symmetric_garment_stays_symmetric():
    measures = measures_of("sweater")

    def mirrored(points: np.ndarray) -> np.ndarray:
        return points * (-1.0, 1.0, 1.0)

    before, after = measures.labeled.vertices, measures.scaled({"chest": 90.0, "sleeve length": 35.0}).vertices
    other = np.array([int(np.argmin(np.linalg.norm(before - point, axis=1))) for point in mirrored(before)])
    assert np.linalg.norm(before[other] - mirrored(before), axis=1).max() < 1e-3  # the mesh itself
    assert np.linalg.norm(after[other] - mirrored(after), axis=1).max() < 1e-2


def test_measures_that_a_mesh_does_not_have_are_refused():
    measures = measures_of("hat")
    with pytest.raises(ParameterError, match="does not have it; expected one of hem, girth, head, length"):
        measures.value("chest")
    with pytest.raises(ParameterError, match=r"head: got 400 cm, but the mesh has 60.9\d* cm; expected 15.2 to 244 cm"):
        measures.scaled({"head": 400.0})
    with pytest.raises(ParameterError, match="contradict each other"):
        measures_of("sweater").scaled({"hem": 60.0, "girth": 200.0, "chest": 90.0})
