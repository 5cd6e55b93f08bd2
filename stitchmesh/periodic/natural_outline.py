# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The natural outline of a pattern, from mesh relaxation alone and therefore within seconds (Yuksel et al. 2012, 7)."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, get_args

import numpy as np

from stitchmesh.errors import ParameterError, check_positive
from stitchmesh.io.contents import FilePath
from stitchmesh.memory_need import BASE_MEMORY, BYTES_PER_STITCH, check_memory
from stitchmesh.mesh import StitchMesh
from stitchmesh.meshrelax.free.free_shape import FreeShape
from stitchmesh.meshrelax.free.relax_freely import relax_mesh_freely
from stitchmesh.meshrelax.free.stitch_sizes import stitch_sizes
from stitchmesh.meshrelax.free.unrolled_tube import roll_up, unroll_tube
from stitchmesh.meshrelax.options import ASPECT, STITCH_WIDTH
from stitchmesh.patterns import Pattern, pattern_mesh, pattern_tube, read_pattern
from stitchmesh.periodic.repeat.torus import torus_mesh
from stitchmesh.run import SHOWN, Run

Form = Literal["flat", "tube", "lattice"]
"""A piece with borders, a tube with joined sides, or a repeat without borders."""
MAKERS = {"flat": pattern_mesh, "tube": pattern_tube, "lattice": torus_mesh}
"""The function that makes the stitch mesh of each form."""
PIECE = 40
"""Smallest width of a piece in stitches, and its smallest height in rows, if its numbers of repeats are not given."""
MOST_STITCHES = 1_000_000
"""Most stitches of an outline. A larger number is a typing error, and its mesh would fill the memory of a machine."""


def natural_outline(
    pattern: Pattern | FilePath,
    form: Form = "flat",
    *,
    columns: int | None = None,
    rows: int | None = None,
    stitch_width: float = STITCH_WIDTH,
    aspect: float = ASPECT,
    run: Run[StitchMesh] = SHOWN,
) -> FreeShape:
    """Relax the stitch mesh of a pattern without a surface, before any yarns are made.

    Args:
        pattern: the pattern, its name in the library or the path of its file.
        form: a flat piece with a cast-on row, a tube in rounds, or a repeat without borders on a lattice.
        columns: repeats side by side; by default 1 on a lattice, and otherwise as many as give 40 stitches.
        rows: repeats one above another; by default 1 on a lattice, and otherwise as many as give 40 rows.
        stitch_width: rest width of plain knit [cm].
        aspect: rest height of plain knit divided by its rest width.
        run: progress after each iteration, and control, whose step is one iteration.

    Raises:
        ParameterError: the form is unknown, a number is out of range, or the pattern is not in the library.
        FileError: the file of the pattern cannot be read.
        PatternError: the pattern is not valid, or its last row does not make the loops of its first one.
        SolverError: ``relax_mesh_freely`` finds no rest.
    """
    chosen = pattern if isinstance(pattern, Pattern) else read_pattern(pattern)
    drawn = outline_mesh(chosen, form, columns=columns, rows=rows, stitch_width=stitch_width, aspect=aspect)
    in_rounds = form == "tube"
    return relax_mesh_freely(
        unroll_tube(drawn) if in_rounds else drawn, stitch_width=stitch_width, aspect=aspect, run=run,
        shown_as=roll_up if in_rounds else None,
    )  # fmt: skip


def outline_mesh(
    pattern: Pattern, form: Form, *, columns: int | None, rows: int | None, stitch_width: float, aspect: float
) -> StitchMesh:
    """Return the stitch mesh of a pattern at the mean size of its stitches; see ``natural_outline`` for the rest."""
    if form not in get_args(Form):
        raise ParameterError(f"form: got {form!r}; expected {', '.join(get_args(Form)[:-1])} or {get_args(Form)[-1]}")
    for name, size in (("stitch_width", stitch_width), ("aspect", aspect)):
        check_positive(name, size)
    whole = 1 if form == "lattice" else PIECE
    columns = -(-whole // pattern.width) if columns is None else columns
    rows = -(-whole // pattern.height) if rows is None else rows
    stitches = columns * pattern.width * rows * pattern.height
    if stitches > MOST_STITCHES:
        found = f"{columns} x {rows} repeats have {stitches:,} stitches"
        raise ParameterError(f"columns, rows: {found}; expected at most {MOST_STITCHES:,}")
    check_memory(
        f"an outline of {stitches:,} stitches", BASE_MEMORY + BYTES_PER_STITCH["meshrelax"] * stitches,
        "fewer columns and rows",
    )  # fmt: skip
    drawn = MAKERS[form](pattern, columns, rows, stitch_width=stitch_width, stitch_height=aspect * stitch_width)
    return _at_mean_size(drawn) if form != "lattice" else drawn


def _at_mean_size(fabric: StitchMesh) -> StitchMesh:
    """Return a piece or a tube that is stretched evenly to the mean rest size of its stitches."""
    sizes = stitch_sizes(fabric, width=1.0, height=1.0)
    across, along = sizes.width.mean(), sizes.height.mean()
    is_round = np.ptp(fabric.vertices[:, 2]) > 0.0
    return replace(fabric, vertices=fabric.vertices * ([across, along, across if is_round else 1.0]))
