# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""USD files hold the B-splines of the yarns; the tests read the files with USD's own library."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdValidation, Vt

from stitchmesh.errors import FileError, YarnError
from stitchmesh.io import read_yarns, write_yarns
from stitchmesh.io.yarn_formats.usd_curves import curves_of_stage
from stitchmesh.io.yarns import yarns_of_usd
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.tiling import instances, tile_yarns
from tests.gallery import shared
from tests.io.yarn_sets import awkward_yarns, ring
from tests.yarnrelax.stockinette import woven_cell

FLOAT32 = 2.0**-24
"""Largest relative error of rounding to float32."""


def written(path: Path, yarns: YarnSet) -> Usd.Stage:
    write_yarns(path, yarns)
    return Usd.Stage.Open(str(path))


def curves_at(stage: Usd.Stage, place: str) -> UsdGeom.BasisCurves:
    return UsdGeom.BasisCurves(stage.GetPrimAtPath(place))


def read_here(path: Path) -> YarnSet:
    """Do in this process what ``read_yarns`` does in a child, whose start takes half a second."""
    return yarns_of_usd(curves_of_stage(path))


def validated(stage: Usd.Stage) -> list[object]:
    """Return what the validators of USD find."""
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(validators) > 10
    return UsdValidation.ValidationContext(validators).Validate(stage)


def primvar(curves: UsdGeom.BasisCurves, name: str) -> tuple[str, list[int]]:
    found = UsdGeom.PrimvarsAPI(curves).GetPrimvar(name)
    return found.GetInterpolation(), list(found.Get())


@pytest.mark.parametrize("suffix", [".usda", ".usdc", ".usd"])
def test_a_stage_states_its_unit_its_up_axis_and_its_default_prim_and_is_valid(tmp_path, suffix):
    stage = written(tmp_path / f"y{suffix}", awkward_yarns())
    assert validated(stage) == []
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.01
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert stage.GetDefaultPrim().GetPath() == "/yarns"
    assert [str(prim.GetPath()) for prim in stage.Traverse()] == [
        "/yarns", "/yarns/wool", "/yarns/wool/colour", "/yarns/wool/surface", "/yarns/closed", "/yarns/open",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("place", "wrap", "chosen"), [("/yarns/closed", "periodic", [0, 2]), ("/yarns/open", "nonperiodic", [1, 3])]
)
def test_curves_are_the_control_points_with_their_wrap_and_diameter(tmp_path, place, wrap, chosen):
    yarns = awkward_yarns()
    stage = written(tmp_path / "y.usda", yarns)
    curves = curves_at(stage, place)
    assert [a.Get() for a in (curves.GetTypeAttr(), curves.GetBasisAttr(), curves.GetWrapAttr())] == [
        "cubic", "bspline", wrap,
    ]  # fmt: skip
    of_chosen = np.isin(yarns.point_yarn, chosen)
    assert list(curves.GetCurveVertexCountsAttr().Get()) == np.diff(yarns.start)[chosen].tolist()
    np.testing.assert_array_equal(curves.GetPointsAttr().Get(), yarns.points[of_chosen].astype(np.float32))
    np.testing.assert_array_equal(curves.GetWidthsAttr().Get(), np.float32(2 * yarns.radius[chosen]))
    assert curves.GetWidthsInterpolation() == "uniform"
    assert primvar(curves, "yarn") == ("uniform", chosen)
    for name in ("row", "face", "part"):
        assert primvar(curves, name) == ("vertex", getattr(yarns, name)[of_chosen].tolist())


def test_yarns_of_one_radius_have_one_width_and_there_is_no_empty_prim(tmp_path):
    yarns = YarnSet.from_curves([ring([0, 0, 0]), ring([0, 0, 1])], closed=[True, True], radius=0.125)
    stage = written(tmp_path / "y.usda", yarns)
    curves = curves_at(stage, "/yarns/closed")
    assert list(curves.GetWidthsAttr().Get()) == [0.25]
    assert curves.GetWidthsInterpolation() == "constant"
    assert not stage.GetPrimAtPath("/yarns/open")


def test_the_extent_encloses_the_tubes_closely(tmp_path):
    stage = written(tmp_path / "y.usda", awkward_yarns())
    again = read_here(tmp_path / "y.usda")  # The curves are rounded to float32.
    for place, closed in (("/yarns/closed", True), ("/yarns/open", False)):
        low, high = np.array(curves_at(stage, place).GetExtentAttr().Get(), dtype=np.float64)
        sampled = again.sampled(16)
        for yarn in np.flatnonzero(again.closed == closed):
            assert (low <= sampled[yarn] - again.radius[yarn]).all()
            assert (sampled[yarn] + again.radius[yarn] <= high).all()
        chosen = again.closed[again.point_yarn] == closed
        radius = again.radius[again.point_yarn][chosen, None]
        # The box of the control points plus the radius is rounded to the nearest float32 and then one step outward.
        step = 4 * FLOAT32 * np.abs([low, high]).max()
        np.testing.assert_allclose(low, (again.points[chosen] - radius).min(axis=0), atol=step, rtol=0)
        np.testing.assert_allclose(high, (again.points[chosen] + radius).max(axis=0), atol=step, rtol=0)


def test_yarns_are_read_in_their_order(tmp_path):
    yarns = awkward_yarns()
    write_yarns(tmp_path / "y.usdc", yarns)
    again = read_yarns(tmp_path / "y.usdc")
    np.testing.assert_array_equal(again.points, yarns.points.astype(np.float32))
    np.testing.assert_allclose(again.radius, yarns.radius, rtol=FLOAT32)
    for name in ("start", "closed", "row", "face", "part"):
        np.testing.assert_array_equal(getattr(again, name), getattr(yarns, name))


def test_a_published_glove_keeps_its_curves(tmp_path):
    glove = read_yarns(shared("yarns/glove.bcc"), radius=0.1)
    write_yarns(tmp_path / "glove.usdc", glove)
    again = read_yarns(tmp_path / "glove.usdc")
    np.testing.assert_array_equal(again.points, glove.points.astype(np.float32))
    np.testing.assert_array_equal(again.start, glove.start)


def stage_of(path: Path, change: Callable[[UsdGeom.BasisCurves], object] | None = None) -> Usd.Stage:
    """Return two closed curves as another program may write them, without numbers or labels."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.Xform.Define(stage, "/fabric")
    curves = UsdGeom.BasisCurves.Define(stage, "/fabric/curves")
    curves.CreateTypeAttr("cubic")
    curves.CreateBasisAttr("bspline")
    curves.CreateWrapAttr("periodic")
    points = np.concatenate([ring([0, 0, 0]), ring([0, 0, 0.5])]).astype(np.float32)
    curves.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    curves.CreateCurveVertexCountsAttr([40, 40])
    if change is not None:
        change(curves)
    stage.Save()
    return stage


def test_unit_up_axis_and_transform_of_a_foreign_stage_are_applied(tmp_path):
    stage = stage_of(tmp_path / "y.usda", lambda curves: curves.CreateWidthsAttr([0.25]))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    place = UsdGeom.Xformable(stage.GetPrimAtPath("/fabric"))
    place.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    place.AddScaleOp().Set(Gf.Vec3f(2, 2, 2))
    stage.Save()
    yarns = read_here(tmp_path / "y.usda")
    x, y, z = 100 * (2 * ring([0, 0, 0.5]) + [1, 2, 3]).T
    expected = np.stack([x, z, -y], axis=1)
    np.testing.assert_allclose(yarns.points[40:], expected, atol=2 * FLOAT32 * 500)  # Float32 of 500 cm.
    np.testing.assert_allclose(yarns.radius, [25.0, 25.0], rtol=1e-12)  # A width of 0.25 m, scaled by 2.
    assert yarns.row.tolist() == [0] * 40 + [1] * 40


def not_finite(curves: UsdGeom.BasisCurves) -> None:
    points = np.full((80, 3), np.nan, dtype=np.float32)
    curves.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(points))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda c: c.GetPrim().GetStage().RemovePrim("/fabric"), "has no curves; expected prims of type BasisCurves"),
        (lambda c: c.GetBasisAttr().Set("bezier"), "/fabric/curves: got periodic cubic bezier curves"),
        (lambda c: c.GetTypeAttr().Set("linear"), "got periodic linear bspline curves"),
        (lambda c: c.GetWrapAttr().Set("pinned"), "got pinned cubic bspline curves; expected cubic bspline"),
        (lambda c: c.GetCurveVertexCountsAttr().Set([40]), "got curves of 40 points, 40 in total; expected 80 points"),
        (lambda c: c.GetCurveVertexCountsAttr().Set([90, -10]), "got curves of 90, -10 points"),
        (lambda c: c.GetCurveVertexCountsAttr().Set([78, 2]), "yarn 1: got 2 control points; a closed yarn needs 3"),
        (lambda c: c.GetPointsAttr().Clear(), "got curves of 40, 40 points, 80 in total; expected 0 points"),
        (lambda c: c.CreateWidthsAttr([0.1] * 80), "got 80 widths of 2 curves; expected one, or one for each curve"),
        (not_finite, "coordinates must be finite"),
    ],
)
def test_each_invalid_stage_gets_its_message(tmp_path, change, message):
    stage_of(tmp_path / "y.usda", change)
    with pytest.raises((FileError, YarnError)) as caught:
        read_here(tmp_path / "y.usda")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_error_of_curves_that_are_no_yarns_names_the_file(tmp_path):
    stage_of(tmp_path / "y.usda", lambda curves: curves.CreateWidthsAttr([0.0]))
    with pytest.raises(FileError, match=r"y\.usda: radius 0, 1: got 0.0; expected a positive number of cm"):
        read_yarns(tmp_path / "y.usda")


def test_a_label_that_some_curves_lack_is_ignored(tmp_path):
    def label(curves: UsdGeom.BasisCurves) -> None:
        curves.CreateWidthsAttr([0.2])
        primvars = UsdGeom.PrimvarsAPI(curves)
        primvars.CreatePrimvar("row", Sdf.ValueTypeNames.IntArray, "vertex").Set([7] * 80)
        primvars.CreatePrimvar("face", Sdf.ValueTypeNames.FloatArray, "vertex").Set([7.5] * 80)
        primvars.CreatePrimvar("part", Sdf.ValueTypeNames.IntArray, "constant").Set([7])

    stage_of(tmp_path / "y.usda", label)
    yarns = read_here(tmp_path / "y.usda")
    assert set(yarns.row) == {7} and set(yarns.face) == {-1} and set(yarns.part) == {0}


def test_tiles_are_instances_of_one_period_with_the_extent_of_the_tiles(tmp_path, caplog):
    cell = woven_cell()
    with caplog.at_level(logging.INFO, "stitchmesh"):
        write_yarns(tmp_path / "y.usda", cell, tiles=(3, 2))
    assert "one period" not in caplog.text
    stage = Usd.Stage.Open(str(tmp_path / "y.usda"))
    wool = ["/yarns/wool", "/yarns/wool/colour", "/yarns/wool/surface"]
    places = ["/yarns", *wool, "/yarns/tiles", "/yarns/tiles/period", "/yarns/tiles/period/open"]
    assert [str(prim.GetPath()) for prim in stage.Traverse()] == places
    instancer = UsdGeom.PointInstancer(stage.GetPrimAtPath("/yarns/tiles"))
    transforms = instancer.ComputeInstanceTransformsAtTime(Usd.TimeCode.Default(), Usd.TimeCode.Default())
    shifts = np.array(transforms)[:, 3, :3]
    np.testing.assert_allclose(shifts, instances(cell.lattice, 3, 2), atol=1e-6)  # float32
    assert [str(path) for path in instancer.GetPrototypesRel().GetTargets()] == ["/yarns/tiles/period"]
    assert validated(stage) == []
    box = UsdGeom.Imageable(stage.GetPrimAtPath("/yarns")).ComputeWorldBound(Usd.TimeCode.Default(), "default")
    piece = tile_yarns(cell, 3, 2)
    low, high = piece.points.min(axis=0) - cell.radius[0], piece.points.max(axis=0) + cell.radius[0]
    np.testing.assert_allclose(box.ComputeAlignedRange().GetMin(), low, atol=1e-6)  # float32
    np.testing.assert_allclose(box.ComputeAlignedRange().GetMax(), high, atol=1e-6)


def test_a_reader_without_instances_reads_one_period(tmp_path):
    cell = woven_cell()
    write_yarns(tmp_path / "tiles.usda", cell, tiles=(3, 2))
    write_yarns(tmp_path / "period.usda", cell)
    first, second = read_here(tmp_path / "tiles.usda"), read_here(tmp_path / "period.usda")
    np.testing.assert_array_equal(first.points, second.points)
    np.testing.assert_array_equal(first.start, second.start)


def test_the_end_of_the_process_that_reads_is_an_error(tmp_path, monkeypatch):
    write_yarns(tmp_path / "y.usda", awkward_yarns())
    script = tmp_path / "python"
    script.write_text("#!/bin/sh\nkill -SEGV $$\n")
    script.chmod(0o755)
    monkeypatch.setattr("sys.executable", str(script))
    with pytest.raises(FileError, match=r"its library could not read it and ended with status -11") as caught:
        read_yarns(tmp_path / "y.usda")
    assert "\n" not in str(caught.value)


def test_a_stage_that_is_composed_of_a_pipe_is_refused(tmp_path):
    os.mkfifo(tmp_path / "other.usda")
    (tmp_path / "y.usda").write_text("#usda 1.0\n(\n    subLayers = [@other.usda@]\n)\n")
    with pytest.raises(FileError, match=r"other\.usda; expected regular files in its own folder only"):
        read_here(tmp_path / "y.usda")


@pytest.mark.parametrize("place", ["subLayers = [@../other.usda@]", "subLayers = [@{}@]"])
def test_files_outside_of_the_folder_of_a_stage_are_refused(tmp_path, place):
    (tmp_path / "folder").mkdir()
    write_yarns(tmp_path / "other.usda", awkward_yarns())
    text = f"#usda 1.0\n(\n    {place.format(tmp_path / 'other.usda')}\n)\n"
    (tmp_path / "folder" / "y.usda").write_text(text)
    with pytest.raises(FileError, match="expected regular files in its own folder only"):
        curves_of_stage(tmp_path / "folder" / "y.usda")
    (tmp_path / "folder" / "other.usda").write_bytes((tmp_path / "other.usda").read_bytes())
    (tmp_path / "folder" / "y.usda").write_text("#usda 1.0\n(\n    subLayers = [@other.usda@]\n)\n")
    assert len(curves_of_stage(tmp_path / "folder" / "y.usda")) == awkward_yarns().yarn_count
