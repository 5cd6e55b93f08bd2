# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Several sets of yarns beside each other as one set, for a picture at one scale."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.yarn.yarn_set import YarnSet

GAP = 0.12
"""Space between two sets, as a part of the width of the widest one."""


def yarns_beside(sets: Sequence[YarnSet]) -> YarnSet:
    """Return sets of yarns as one, from left to right along x, all on one ground.

    The numbers of rows and stitches of the points stay those of their own set.

    Args:
        sets: sets without a lattice; the palette of the first one colours all.

    Raises:
        ParameterError: there is no set, or one has a lattice.
    """
    if not sets or any(yarns.lattice is not None for yarns in sets):
        raise ParameterError("yarns_beside: expected at least one set of yarns, all without a lattice")
    widest = max(float(np.ptp(yarns.points[:, 0])) for yarns in sets)
    points, edge = [], 0.0
    for yarns in sets:
        low = yarns.points.min(axis=0)
        middle = (low[2] + yarns.points[:, 2].max()) / 2
        points.append(yarns.points + np.array([edge - low[0], -low[1], -middle]))
        edge += float(np.ptp(yarns.points[:, 0])) + GAP * widest
    first = np.cumsum([0, *(len(yarns.points) for yarns in sets)])
    starts = [yarns.start[:-1] + begin for yarns, begin in zip(sets, first[:-1], strict=True)]
    return YarnSet(
        points=np.concatenate(points),
        start=np.concatenate([*starts, first[-1:]]),
        closed=np.concatenate([yarns.closed for yarns in sets]),
        radius=np.concatenate([yarns.radius for yarns in sets]),
        rest_length=np.concatenate([yarns.rest_length for yarns in sets]),
        row=np.concatenate([yarns.row for yarns in sets]),
        face=np.concatenate([yarns.face for yarns in sets]),
        part=np.concatenate([yarns.part for yarns in sets]),
        colour=np.concatenate([yarns.colour for yarns in sets]),
        natural_curvature=np.concatenate([yarns.natural_curvature for yarns in sets]),
        palette=sets[0].palette,
        drawn_radius=np.concatenate([yarns.drawn_radius for yarns in sets]),
        mass_per_length=np.concatenate([yarns.mass_per_length for yarns in sets]),
        made_of=sets[0].made_of if all(yarns.made_of == sets[0].made_of for yarns in sets) else None,
    )
