# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Units of length in files, and tests of the unit by the size of a mesh. In the program lengths are in centimetres.

A mesh that is smaller than a doll's garment or larger than a train of lace was probably read in a wrong unit.
"""

from __future__ import annotations

from os import fspath

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import FloatArray, extent

CENTIMETRES: dict[str, float] = {"mm": 0.1, "cm": 1.0, "dm": 10.0, "m": 100.0, "inch": 2.54}
"""Number of centimetres in each unit of length that a file may have."""
DEFAULT_UNIT = "cm"
"""Unit of a file if neither the file nor the caller states a unit."""
SMALLEST_GARMENT, LARGEST_GARMENT = 10.0, 400.0
"""Largest dimension of the smallest garment, for a doll, and of the largest garment, such as a blanket or a train
[cm]."""


def centimetres(unit: str) -> float:
    """Return the number of centimetres in a unit.

    Raises:
        ParameterError: there is no unit of that name.
    """
    if unit not in CENTIMETRES:
        raise ParameterError(f"unit: got {unit!r}; expected one of {', '.join(CENTIMETRES)}")
    return CENTIMETRES[unit]


def check_unit_left_out(path: FilePath, scale: float) -> None:
    """Check that the caller gave no unit for a format that prescribes or states its unit.

    Args:
        path: the file, for the error message.
        scale: number of centimetres in the given unit; 1 if no unit was given.

    Raises:
        ParameterError: a unit was given.
    """
    if scale != 1.0:
        raise ParameterError(f"unit: {fspath(path)} is of a format that fixes or states its unit; leave the unit out")


def other_units(points: FloatArray, unit: str) -> dict[str, str]:
    """Return the units in which a mesh would have the size of a garment, if it does not have it already.

    Args:
        points: vertices of the mesh, read in ``unit`` [cm], shape (V, 3).
        unit: the unit in which its file was read.

    Returns:
        The size in each such unit in words; empty if the mesh has the size of a garment already.
    """
    if _garment_sized(points):
        return {}
    read_in = {other: points * (size / centimetres(unit)) for other, size in CENTIMETRES.items()}
    return {other: extent(scaled) for other, scaled in read_in.items() if _garment_sized(scaled)}


def size_doubt(points: FloatArray, unit: str, *, stated: bool) -> str:
    """Return a sentence about a mesh of impossible size, with its size in other units; no text if the size is possible.

    Args:
        points: vertices of the mesh, read in ``unit`` [cm], shape (V, 3).
        unit: the unit in which its file was read.
        stated: whether the file or its format states the unit, so that the user cannot give another one.
    """
    if _garment_sized(points):
        return ""
    kind = "too small" if np.ptp(points, axis=0).max() < SMALLEST_GARMENT else "too large"
    others = other_units(points, unit)
    if stated:
        said = f"the mesh, in {unit} as its file states, is {extent(points)}, {kind} for a garment"
        scales = {centimetres(other) / centimetres(unit): size for other, size in others.items()}
        return "; ".join([said, *(f"scale it by {scale:g} for {size}" for scale, size in scales.items())])
    said = f"the mesh, read in {unit}, is {extent(points)}, {kind} for a garment"
    readings = [f"in {other} {size}: --unit {other}" for other, size in others.items()]
    return "; ".join([said, *(readings or ["check its size"])])


def _garment_sized(points: FloatArray) -> bool:
    """Return whether points [cm] have a largest dimension that a garment can have."""
    return SMALLEST_GARMENT <= float(np.ptp(points, axis=0).max()) <= LARGEST_GARMENT
