# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Masses of triangles and of rods along seams."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.dynamics.cloth_system import rod_masses, triangle_masses
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.seam_rod import SeamMaterial
from tests.mixed.triangles.flat_cloths import rectangle, with_seam

KNIT = ClothMaterial("knit", 1000.0, 3000.0, 400.0, 0.4, 5.0, 2.0, 0.02)


def test_the_mass_of_a_cloth_is_that_of_its_area():
    mass = triangle_masses(rectangle("irregular", 6, 5, 3.0, 2.0), KNIT)
    assert mass.sum() == pytest.approx(0.02 * 6.0) and mass.min() > 0.0


def test_each_panel_has_its_own_density():
    cloth = rectangle("diagonals", 2, 1)
    cloth = replace(cloth, panel=np.array([0, 0, 1, 1]), panel_names=("left", "right"))
    mass = triangle_masses(cloth, [KNIT, replace(KNIT, density=0.05)])
    np.testing.assert_allclose(mass, [0.005, 0.005, 0.0125, 0.0125])


def test_a_rod_has_half_of_the_mass_of_each_edge_at_its_ends():
    cloth = with_seam(rectangle("diagonals", 2, 2, 1.0, 3.0), [[1, 4], [4, 7]])
    rod = SeamMaterial(1.0, 1.0, density=0.2)
    np.testing.assert_allclose(rod_masses(cloth, rod)[[1, 4, 7, 0]], [0.15, 0.3, 0.15, 0.0])
    np.testing.assert_allclose(rod_masses(cloth, rod, [0.0, 0.5])[[1, 4, 7]], [0.0, 0.075, 0.075])


def test_wrong_weights_are_refused():
    cloth = with_seam(rectangle("diagonals", 2, 2), [[1, 4], [4, 7]])
    with pytest.raises(ParameterError, match=r"element 1 has -0\.5; expected 0 to 1"):
        rod_masses(cloth, SeamMaterial(1.0, 1.0), [1.0, -0.5])
