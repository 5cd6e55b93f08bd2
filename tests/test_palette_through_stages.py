# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The colours and the apparent radius of yarns survive every stage and every file without loss."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import h5py
import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import ParameterError, YarnError
from stitchmesh.mesh.palette import make_palette
from stitchmesh.quality import quality_named
from stitchmesh.yarn import APPARENT_OVER_CONTACT
from stitchmesh.yarnrelax.together.relax_cells import relax_cells
from tests.gallery import tube

PALETTE = make_palette(["#aa2233", "cream", "navy"])
QUICK = replace(quality_named("draft"), tolerance=0.5, max_iterations=20)


@cache
def fabric() -> sm.StitchMesh:
    panels = replace(sm.label(tube(8, 3)), palette=PALETTE)
    return sm.tessellate(panels, stitch_width=0.8)


@cache
def yarns() -> sm.YarnSet:
    return sm.generate_yarns(fabric(), yarn_radius=0.08, drawn_radius=0.12, quality=QUICK)


def test_the_stages_of_a_mesh_keep_the_palette():
    relaxed = sm.relax_mesh(fabric(), surface=tube(8, 3)).fabric
    edited = sm.apply_edit(relaxed, sm.Edit("stripe", {"yarn": 1, "rows": [2]})).fabric
    spiral = sm.apply_edit(edited, sm.Edit("spiral")).fabric
    longer = sm.apply_edit(edited, sm.Edit("insert_row", {"face": int(np.flatnonzero(edited.row == 2)[0])})).fabric
    for made in (fabric(), relaxed, edited, spiral, longer, sm.apply_pattern(edited, sm.read_pattern("rib2x2"))):
        np.testing.assert_array_equal(made.palette, PALETTE)


def test_generated_and_relaxed_yarns_keep_the_palette_and_the_apparent_radius():
    free = sm.relax_yarns(yarns(), quality=QUICK, device="cpu").yarns
    purled = int(np.flatnonzero(fabric().row == 2)[0])
    after = sm.apply_edit(fabric(), sm.Edit("change_stitch", {"faces": [purled], "stitch": "p"})).fabric
    anew, start = sm.regenerate_yarns(free, fabric(), after, quality=QUICK)
    for made in (yarns(), free, anew, start):
        np.testing.assert_array_equal(made.palette, PALETTE)
        assert (made.drawn_radius == 0.12).all() and (made.radius == 0.08).all()


def test_a_repeat_keeps_them_on_its_lattice_and_in_tiles():
    chart = replace(sm.parse_pattern("chart colours:\n01\n10\n"), palette=tuple(map(tuple, PALETTE[:2].tolist())))
    relaxed = sm.swatch(chart, quality=QUICK, device="cpu", yarn_radius=0.1, drawn_radius=0.15).yarns
    cells = relax_cells([relaxed, relaxed], quality=QUICK, device="cpu")
    tiles = sm.tile_yarns(relaxed, 2, 1), sm.tile_yarns(relaxed, 1, 2, periodic=True)
    for made in (relaxed, cells.cells[1].yarns, *tiles):
        np.testing.assert_array_equal(made.palette, PALETTE[:2])
        np.testing.assert_allclose(made.drawn_radius, 0.15, rtol=1e-12)  # the radius is scaled a few times


def test_files_without_loss_keep_them_and_older_files_are_read(tmp_path):
    sm.write_stitches(tmp_path / "s.h5", fabric())
    sm.write_yarns(tmp_path / "y.h5", yarns())
    np.testing.assert_array_equal(sm.read_stitches(tmp_path / "s.h5").palette, PALETTE)
    read = sm.read_yarns(tmp_path / "y.h5")
    np.testing.assert_array_equal(read.palette, PALETTE)
    np.testing.assert_array_equal(read.drawn_radius, yarns().drawn_radius)
    assert sm.read_yarns(tmp_path / "y.h5", radius=0.04).drawn_radius == pytest.approx(0.06)  # the ratio is kept
    for name in ("s.h5", "y.h5"):  # older files have neither
        with h5py.File(tmp_path / name, "a") as file:
            del file["palette"]
            if "drawn_radius" in file:
                del file["drawn_radius"]
    assert sm.read_stitches(tmp_path / "s.h5").palette.shape == (0, 3)
    old = sm.read_yarns(tmp_path / "y.h5")
    assert old.palette.shape == (0, 3)
    np.testing.assert_array_equal(old.drawn_radius, old.radius)


def test_the_apparent_radius_is_given_or_follows_from_the_contact_radius():
    plain = sm.generate_yarns(fabric(), yarn_radius=0.08, quality=QUICK)
    np.testing.assert_allclose(plain.drawn_radius, APPARENT_OVER_CONTACT * 0.08)
    curve = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]]
    assert sm.YarnSet.from_curves([curve], closed=[False], radius=0.1).drawn_radius.tolist() == [0.1]
    with pytest.raises(ParameterError, match=r"drawn radius: got 1 cm for yarn with a contact radius of 0.08 cm"):
        sm.generate_yarns(fabric(), yarn_radius=0.08, drawn_radius=1.0)
    with pytest.raises(YarnError, match=r"drawn_radius 0, .*: got 0\.0; expected a positive number"):
        replace(yarns(), drawn_radius=np.zeros(yarns().yarn_count))
    with pytest.raises(YarnError, match="palette: got shape"):
        replace(yarns(), palette=[[1, 2]])
