# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Reading of sewing patterns: panels and seams."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import FileError, MeshError, ParameterError
from stitchmesh.mesh import BORDER
from stitchmesh.shaping.panels.panel_mesh import PanelMesh
from stitchmesh.shaping.panels.read_panels import read_panels
from tests.shaping.panels.sewing_patterns import PatternText, bag, skirt, t_shirt


def sewn_pairs(panels: PanelMesh) -> list[tuple[int, int]]:
    return sorted((min(seam.panels), max(seam.panels)) for seam in panels.seams)


SEWN = {
    bag: [(0, 1)],
    skirt: [(0, 1), (0, 3), (1, 2), (2, 3)],
    t_shirt: [*[(0, 1)] * 4, (0, 2), (0, 3), (1, 2), (1, 3), (2, 2), (3, 3)],
}
"""Pairs of panels with a seam: a skirt is a ring of gores, and sleeves are sewn to themselves."""


@pytest.mark.parametrize(("pattern", "sewn"), SEWN.items())
def test_panels_are_cut_at_seams_and_the_sides_of_seams_lie_on_each_other(tmp_path, pattern, sewn):
    panels = pattern().read(tmp_path)
    assert sewn_pairs(panels) == sewn
    mesh = panels.mesh
    inner = np.flatnonzero(mesh.twin != BORDER)
    panel = panels.face_panel[mesh.side_face]
    assert (panel[inner] == panel[mesh.twin[inner]]).all()
    for seam in panels.seams:
        assert (mesh.vertices[seam.first] == mesh.vertices[seam.second]).all()
        assert not np.isin(seam.first[1:-1], seam.second[1:-1]).any()


def rewritten(text: PatternText, corner: Callable[[int, int, int], str], extra: Sequence[str] = ()) -> PatternText:
    """The same pattern with the corners of its faces written anew, from the face, the vertex and the texture vertex."""
    lines, face = list(extra), 0
    for line in text.lines:
        if line.startswith("f "):
            pairs = [tuple(map(int, word.split("/"))) for word in line.split()[1:]]
            lines.append("f " + " ".join(corner(face, *pair) for pair in pairs))
            face += 1
        elif not (extra and line[:2] in ("v ", "vt")):
            lines.append(line)
    return PatternText(lines)


def each_panel_for_itself(text: PatternText) -> PatternText:
    """The pattern with one vertex for each texture vertex, as Marvelous Designer and CLO write it, with normals."""
    places = [line for line in text.lines if line.startswith("v ")]
    textures = [line for line in text.lines if line.startswith("vt")]
    corners = {}
    rewritten(text, lambda _, v, t: corners.setdefault(t, v) and "")
    # Programs round the two sides of a seam each for itself.
    points = [
        np.array(places[corners[t + 1] - 1].split()[1:], dtype=float) + 1e-5 * (t % 2) for t in range(len(textures))
    ]
    extra = [*("v " + " ".join(f"{x:.6f}" for x in point) for point in points), *textures, "vn 0 0 1"]
    return rewritten(text, lambda _, v, t: f"{t}/{t}/1", extra)


def each_face_for_itself(text: PatternText) -> PatternText:
    """The pattern with vertices and texture vertices that no two faces share."""
    places = [line for line in text.lines if line.startswith("v ")]
    textures = [line for line in text.lines if line.startswith("vt")]
    own: list[tuple[int, int]] = []
    rewritten(text, lambda _, v, t: own.append((v, t)) or "")
    count = iter(range(1, len(own) + 1))
    extra = [*(places[v - 1] for v, _ in own), *(textures[t - 1] for _, t in own)]

    def corner(*_: int) -> str:
        number = next(count)
        return f"{number}/{number}"

    return rewritten(text, corner, extra)


@pytest.mark.parametrize(
    ("pattern", "style"),
    # Front and back of the T-shirt touch each other in the texture: without common vertices no cut is seen there.
    [(t_shirt, each_panel_for_itself), (bag, each_face_for_itself)],
)
def test_every_style_of_writing_gives_the_same_panels_and_seams(tmp_path, pattern, style):
    expected, found = pattern().read(tmp_path), style(pattern()).read(tmp_path)
    assert (found.face_panel == expected.face_panel).all() and sewn_pairs(found) == sewn_pairs(expected)
    assert sorted(len(seam.first) for seam in found.seams) == sorted(len(seam.first) for seam in expected.seams)
    assert np.allclose(found.texture[found.mesh.face_vertex], expected.texture[expected.mesh.face_vertex])
    assert np.abs(found.mesh.corner_position - expected.mesh.corner_position).max() < 2e-5  # as it was written


def test_vertices_that_are_apart_by_more_than_rounding_are_not_sewn(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1.01 0 0\nv 2 0 0\nv 2 1 0\nv 1.01 1 0\n"
    text += "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 3 0\nvt 4 0\nvt 4 1\nvt 3 1\nf 1/1 2/2 3/3 4/4\nf 5/5 6/6 7/7 8/8\n"
    path = tmp_path / "apart.obj"
    path.write_text(text)
    assert not read_panels(path).seams
    path.write_text(text.replace("1.01", "1.0005"))
    assert sewn_pairs(read_panels(path)) == [(0, 1)]


def test_panels_are_found_by_number_and_by_the_names_of_their_faces(tmp_path):
    lines = bag().lines
    half = [place for place, line in enumerate(lines) if line.startswith("f ")][80]
    panels = PatternText(["o bag", "g front", *lines[:half], "g back", *lines[half:]]).read(tmp_path)
    assert panels.names == (("bag", "front"), ("bag", "back"))
    assert [panels.panels_named(name) for name in (1, "1", "back", "bag")] == [[1], [1], [1], [0, 1]]
    with pytest.raises(
        ParameterError, match="panel sleeve does not exist; expected 0 to 1; or a name: back, bag, front"
    ):
        panels.panels_named("sleeve")


def test_panels_that_are_turned_inside_out_keep_their_seams(tmp_path):
    panels = bag().read(tmp_path)
    turned = panels.turned_inside_out()
    assert np.allclose(turned.mesh.face_vector_area, -panels.mesh.face_vector_area)
    assert sewn_pairs(turned) == sewn_pairs(panels)
    again = turned.turned_inside_out()
    assert (again.mesh.face_vertex == panels.mesh.face_vertex).all()


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
