# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""USD files of yarns that move, which are written frame by frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.errors import FileError
from stitchmesh.io.mesh_sequences import read_moving_mesh
from stitchmesh.io.yarn_formats import animated_usd
from stitchmesh.io.yarn_formats.animated_usd import UsdFrame, write_animated_usd
from tests.fuzz.reader import small_yarns

FRAMES = 5
SQUARE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])


def frames() -> Iterator[UsdFrame]:
    """Yarns and a square that rise by 1 cm in each frame."""
    yarns = small_yarns()
    for number in range(FRAMES):
        lift = np.array([0.0, 0.0, float(number)])
        moved = replace(yarns, points=yarns.points + lift)
        yield UsdFrame(number / 8.0, moved, SQUARE + lift, np.array([[0, 1, 2], [0, 2, 3]]), {})


@pytest.mark.parametrize("suffix", [".usda", ".usdc", ".usd"])
def test_what_goes_to_the_file_between_frames_is_read_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    from pxr import Usd, UsdGeom

    monkeypatch.setattr(animated_usd, "MOST_UNSAVED", 0)
    path = tmp_path / f"animation{suffix}"
    assert write_animated_usd(path, frames(), frames_per_second=8.0) == FRAMES
    assert [each.name for each in tmp_path.iterdir()] == [path.name]
    assert (path.read_bytes()[:5] == b"#usda") == (suffix == ".usda")
    found = read_moving_mesh(path)
    np.testing.assert_array_equal(found.motion.times, np.arange(FRAMES) / 8.0)
    np.testing.assert_array_equal(found.motion.vertices[:, 0, 2], np.arange(FRAMES))
    stage = Usd.Stage.Open(str(path))
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0.0, FRAMES - 1.0)
    curves = [UsdGeom.BasisCurves(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.BasisCurves)]
    assert len(curves) == 2  # Closed yarns and open ones.
    for each in curves:
        first, last = (np.array(each.GetPointsAttr().Get(code)) for code in (0, FRAMES - 1))
        np.testing.assert_allclose(last - first, np.tile([0.0, 0.0, FRAMES - 1.0], (len(first), 1)), atol=1e-6)


def test_an_animation_that_fails_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "animation.usdc"
    write_animated_usd(path, frames(), frames_per_second=8.0)
    before = path.read_bytes()

    def broken() -> Iterator[UsdFrame]:
        yield from frames()
        raise FileError("no more frames")

    with pytest.raises(FileError, match="no more frames"):
        write_animated_usd(path, broken(), frames_per_second=8.0)
    with pytest.raises(FileError, match="got no frame; expected at least one"):
        write_animated_usd(path, iter(()), frames_per_second=8.0)
    assert path.read_bytes() == before
    assert [each.name for each in tmp_path.iterdir()] == [path.name]
