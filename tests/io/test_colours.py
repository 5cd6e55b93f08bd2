# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colour numbers of yarns: in memory, in files and as displayed colours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import YarnError
from stitchmesh.io.yarns import read_yarns, write_yarns
from stitchmesh.mesh.palette import make_palette
from tests.io.yarn_sets import awkward_yarns

COLOURS = [2, 0, 1, 2]


def test_yarns_of_a_file_without_colours_have_colour_0(tmp_path):
    write_yarns(tmp_path / "y.bcc", replace(awkward_yarns(), colour=COLOURS))
    assert read_yarns(tmp_path / "y.bcc", radius=0.1).colour.tolist() == [0, 0, 0, 0]


def test_invalid_colours_are_errors():
    with pytest.raises(YarnError, match="yarn 1: got colour -1; colours are numbered from 0"):
        replace(awkward_yarns(), colour=[0, -1, 0, 0])
    with pytest.raises(YarnError, match=r"colour: got shape \(2,\); expected \(4,\)"):
        replace(awkward_yarns(), colour=[0, 1])


@pytest.mark.parametrize("suffix", [".h5", ".usdc", ".vtp"])
def test_palettes_and_apparent_radii_are_written_and_read(tmp_path, suffix):
    given = awkward_yarns()
    palette = make_palette(["#aa2233", "#010203", "cream"])
    yarns = replace(given, colour=COLOURS, palette=palette, drawn_radius=1.5 * given.radius)
    write_yarns(tmp_path / f"y{suffix}", yarns)
    read = read_yarns(tmp_path / f"y{suffix}")
    np.testing.assert_array_equal(read.palette, palette)
    assert read.colour.tolist() == COLOURS
    np.testing.assert_allclose(read.radius, yarns.radius, rtol=2.0**-23)  # USD stores float32
    np.testing.assert_allclose(read.drawn_radius, yarns.drawn_radius, rtol=2.0**-23)
    given_radius = read_yarns(tmp_path / f"y{suffix}", radius=0.05).radius
    assert (given_radius == 0.05).all()


def test_stock_colours_are_written_and_need_no_palette(tmp_path):
    write_yarns(tmp_path / "y.vtp", replace(awkward_yarns(), colour=COLOURS))
    assert read_yarns(tmp_path / "y.vtp").palette.shape == (0, 3)


def test_usd_has_the_colours_that_renderers_show(tmp_path):
    """``displayColor`` is in linear light, one colour for each curve; the material of the curves reads it."""
    from pxr import Usd, UsdGeom, UsdShade

    palette = [[170, 34, 51], [0, 0, 0], [255, 255, 255]]
    write_yarns(tmp_path / "y.usda", replace(awkward_yarns(), colour=COLOURS, palette=palette))
    stage = Usd.Stage.Open(str(tmp_path / "y.usda"))
    curves = UsdGeom.BasisCurves.Get(stage, "/yarns/closed")  # yarns 0 and 2 of the set
    shown = curves.GetDisplayColorPrimvar()
    assert shown.GetInterpolation() == "uniform"
    np.testing.assert_allclose(shown.Get(), [[1.0] * 3, [0.0] * 3], atol=1e-7)
    material, _ = UsdShade.MaterialBindingAPI(curves).ComputeBoundMaterial()
    surface, _, _ = material.ComputeSurfaceSource()
    reader = surface.GetInput("diffuseColor").GetConnectedSources()[0][0].source
    assert UsdShade.Shader(reader).GetInput("varname").Get() == "displayColor"
