# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Small sets of yarns for the tests of file formats."""

from __future__ import annotations

import dataclasses
from pathlib import Path

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


ODD_POINTS = ("external link", "soft link", "external data", "virtual", "empty", "bomb", "huge", "chunks")
"""Ways to store the points of yarns in HDF5 that a reader refuses."""


def store_points_oddly(path: Path, kind: str, other: str) -> None:
    """Store the points of a file of yarns in one of ``ODD_POINTS``; links name another file."""
    import h5py

    with h5py.File(path, "r+") as file:
        shape = file["points"].shape
        del file["points"]
        match kind:
            case "external link":
                file["points"] = h5py.ExternalLink(other, "/points")
            case "soft link":
                file["points"] = h5py.SoftLink("/start")
            case "external data":
                file.create_dataset("points", shape, "f8", external=[(other, 0, 10_000)])
            case "virtual":
                layout = h5py.VirtualLayout(shape, "f8")
                layout[:] = h5py.VirtualSource(other, "points", shape)
                file.create_virtual_dataset("points", layout)
            case "empty":
                file.create_dataset("points", data=h5py.Empty("f8"))
            case "bomb":
                file.create_dataset("points", (10**6, 3), "f8", compression="gzip", chunks=(10**6, 3), fillvalue=0.0)
            case "huge":
                file.create_dataset("points", (2**40, 3), "f8", chunks=(1000, 3))
            case "chunks":  # The library needs 4 kB for each of them.
                file.create_dataset("points", (10**5, 3), "f8", chunks=(1, 3))


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
