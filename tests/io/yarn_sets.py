# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Small sets of yarns for the tests of file formats."""

from __future__ import annotations

import dataclasses

import numpy as np

from stitchmesh.yarn import YarnSet


def awkward_yarns() -> YarnSet:
    """Return closed and open yarns with the fewest control points, and with numbers without a short decimal form."""
    rng = np.random.default_rng(3)
    curves = [
        rng.standard_normal((count, 3)) * scale for count, scale in ((3, 1 / 3), (4, np.pi), (30, 1e3), (17, 1e-3))
    ]
    yarns = YarnSet.from_curves(curves, closed=[True, False, True, False], radius=[0.1, 1 / 3, 1e-3, 7.0])
    count = len(yarns.points)
    return dataclasses.replace(
        yarns,
        rest_length=yarns.lengths * 1.01,
        row=np.arange(count) // 4,
        face=np.arange(count) - 1,
        part=np.arange(count) % 5,
        natural_curvature=rng.standard_normal(count),
        mass_per_length=[0.01 / 7, np.nan, 0.1, np.nan],
    )


def ring(centre: list[float], size: float = 1.0, count: int = 40) -> np.ndarray:
    """Return the control points of a ring around the z axis, shape (count, 3)."""
    angle = 2 * np.pi * np.arange(count) / count
    return np.array(centre) + size * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)


def assert_same(first: YarnSet, second: YarnSet) -> None:
    """Check that every field of two sets has the same bits."""
    for field in dataclasses.fields(YarnSet):
        a, b = getattr(first, field.name), getattr(second, field.name)
        if field.name == "lattice" and a is not None:
            a, b = a.periods, b.periods
        np.testing.assert_array_equal(a, b, err_msg=field.name)
