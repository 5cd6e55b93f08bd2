# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The add-on in Blender itself, without a window.

The module bpy needs another NumPy than StitchMesh, so it stands in a Python of its own, which the variable
``STITCHMESH_BPY_PYTHON`` names.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.io.blender_addon import write_blender_addon
from tests.gallery import ROOT, tube

PYTHON = os.environ.get("STITCHMESH_BPY_PYTHON")


@pytest.mark.nightly
@pytest.mark.skipif(PYTHON is None, reason="STITCHMESH_BPY_PYTHON names no Python with the module bpy")
def test_a_mesh_is_knitted_in_its_place_and_again_and_an_error_is_one_line(tmp_path):
    assert PYTHON is not None
    write_blender_addon(tmp_path / "addon.zip")
    with zipfile.ZipFile(tmp_path / "addon.zip") as archive:
        archive.extractall(tmp_path / "installed")
    sm.write_mesh(tmp_path / "tube.obj", tube(8, 3, radius=20.0, height=12.0))
    program, out = tmp_path / "stitchmesh", tmp_path / "found.json"
    program.write_text(f'#!/bin/sh\nPYTHONPATH="{ROOT}" exec "{sys.executable}" -m stitchmesh "$@"\n')
    program.chmod(0o755)
    script = Path(__file__).with_name("in_blender.py")
    words = [PYTHON, script, tmp_path / "installed", tmp_path / "tube.obj", program, out]
    child = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True)
    assert out.is_file(), child.stdout + child.stderr
    found = json.loads(out.read_text())
    assert found["states"] == [["FINISHED"]] * 2
    assert sorted(found["objects"]) == ["CURVES", "MESH"]  # the second run replaced the yarns of the first one
    points = found["attributes"]["position"][1]
    kept = {name: found["attributes"][name] for name in ("row", "stitch", "length", "yarn", "wool", "radius")}
    assert kept == {"row": ["POINT", points], "stitch": ["POINT", points], "length": ["POINT", points],
                    "radius": ["POINT", points], "yarn": ["CURVE", found["yarns"]],
                    "wool": ["CURVE", found["yarns"]]}  # fmt: skip
    # what the user changed in the material stays; 1/8 is exact in float32
    assert found["materials"] == [["StitchMesh wool", 0.125]] and found["curves"] == 1
    assert found["drawn"] > 3 * found["yarns"]
    for garment, yarns in (found["boxes"], found["moved"]):
        # a stitch is 8 cm wide, 0.8 units of this scene; yarns stand off the surface by less
        np.testing.assert_allclose(yarns, garment, atol=0.8)
    np.testing.assert_allclose(np.subtract(found["moved"], found["boxes"])[:, :, 0], 5.0, atol=1e-4)  # float32
    assert found["length"] > 2 * np.pi * 2.0  # a yarn goes around the tube, whose radius is 2 units, at least once
    assert "no-such-pattern" in found["error"] and len(found["error"].strip().splitlines()) == 1
    assert sorted(found["after_error"]) == ["CURVES", "MESH"]
