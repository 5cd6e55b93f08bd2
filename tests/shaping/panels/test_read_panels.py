# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Reading of sewing patterns: panels and seams."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import FileError, MeshError
from stitchmesh.mesh import BORDER
from stitchmesh.shaping.panels.panel_mesh import PanelMesh
from stitchmesh.shaping.panels.read_panels import read_panels
from tests.shaping.panels.sewing_patterns import bag, skirt, t_shirt


def sewn_pairs(panels: PanelMesh) -> list[tuple[int, int]]:
    return sorted((min(seam.panels), max(seam.panels)) for seam in panels.seams)


def test_a_bag_has_two_panels_and_a_seam_around_three_sides(tmp_path):
    panels = bag().read(tmp_path)
    assert panels.panel_count == 2 and sewn_pairs(panels) == [(0, 1)]
    assert len(panels.seams[0].first) == 11 + 9 + 11 - 2  # nodes of the grid along two sides and below


def test_a_skirt_has_four_gores_in_a_ring(tmp_path):
    panels = skirt().read(tmp_path)
    assert panels.panel_count == 4 and sewn_pairs(panels) == [(0, 1), (0, 3), (1, 2), (2, 3)]


def test_a_t_shirt_has_sleeves_that_are_sewn_to_themselves(tmp_path):
    panels = t_shirt().read(tmp_path)
    assert panels.panel_count == 4
    body, armholes = [(0, 1)] * 4, [(0, 2), (0, 3), (1, 2), (1, 3)]
    assert sewn_pairs(panels) == sorted([*body, *armholes, (2, 2), (3, 3)])


@pytest.mark.parametrize("pattern", [bag, skirt, t_shirt])
def test_panels_are_cut_at_seams_and_the_sides_of_seams_lie_on_each_other(tmp_path, pattern):
    panels = pattern().read(tmp_path)
    mesh = panels.mesh
    inner = np.flatnonzero(mesh.twin != BORDER)
    panel = panels.face_panel[mesh.side_face]
    assert (panel[inner] == panel[mesh.twin[inner]]).all()
    for seam in panels.seams:
        assert (mesh.vertices[seam.first] == mesh.vertices[seam.second]).all()
        assert not np.isin(seam.first[1:-1], seam.second[1:-1]).any()


def test_a_dart_is_a_seam_of_a_panel_with_itself_that_ends_at_its_tip(tmp_path):
    # Two quads below are cut from each other by a dart between vertex 2 and its tip, vertex 5; two above are joined.
    places = [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1), (0, 2), (1, 2), (2, 2)]
    text = "".join(f"v {x} {y} 0\n" for x, y in places) + "".join(f"vt {x} {y}\n" for x, y in [*places, (1.2, 0)])
    text += "f 1/1 2/2 5/5 4/4\nf 2/10 3/3 6/6 5/5\nf 4/4 5/5 8/8 7/7\nf 5/5 6/6 9/9 8/8\n"
    path = tmp_path / "dart.obj"
    path.write_text(text)
    panels = read_panels(path)
    assert panels.panel_count == 1 and len(panels.seams) == 1
    seam = panels.seams[0]
    assert seam.panels == (0, 0) and len(seam.first) == 2
    assert seam.first[-1] == seam.second[-1] or seam.first[0] == seam.second[0]  # the tip


def test_groups_are_panels_where_there_are_no_texture_coordinates(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n"
    path = tmp_path / "groups.obj"
    path.write_text(text + "g left\nf 1 2 5 4\ng right\nf 2 3 6 5\n")
    panels = read_panels(path, unit="m")
    assert panels.panel_count == 2 and sewn_pairs(panels) == [(0, 1)]
    # The panels are level in depth: their texture is the position to the right and upwards [cm].
    assert np.allclose(panels.texture, panels.mesh.vertices[:, :2])
    path.write_text(text + "f 1 2 5 4\nf 2 3 6 5\n")
    with pytest.raises(FileError, match=r"groups.obj: has no texture coordinates \(vt\) and no groups"):
        read_panels(path)


def test_panels_check_themselves(tmp_path):
    panels = bag().read(tmp_path)
    with pytest.raises(MeshError, match=r"texture: got shape \(3, 2\); expected finite numbers of shape"):
        replace(panels, texture=np.zeros((3, 2)))
    with pytest.raises(MeshError, match="joins two panels; cut the mesh along its seams"):
        replace(panels, face_panel=np.arange(panels.mesh.face_count) % 2)
    seam = panels.seams[0]
    with pytest.raises(MeshError, match=r"seam 0 of panels .*: its lines do not run along borders"):
        replace(panels, seams=(replace(seam, first=seam.first[::-1]),))
    with pytest.raises(MeshError, match="expected two lines of equally many vertices"):
        replace(seam, first=seam.first[1:])
