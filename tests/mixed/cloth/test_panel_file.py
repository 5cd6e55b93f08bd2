# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files of panels and seams: the cloth of a file, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import FileError
from stitchmesh.mixed.cloth.panel_file import read_panels
from tests.gallery import ROOT
from tests.mixed.cloth.panel_shapes import edge_stretch

TEXT = """
edge_length = 1.5

[[panels]]
name = "front"
outline = [[0, 0], [12, 0], [12, 8], [0, 8.5]]
position = { radius = 3.8197186342054885 }

[[panels]]
name = "back"
outline = [[0, 0], [12, 0], [12, 8.5], [0, 8]]
position = { origin = [0, 0, -7.6394372684109770], x_axis = [-1, 0, 0], radius = 3.8197186342054885 }

[[seams]]
first = { panel = "front", start = 1, end = 2 }
second = { panel = "back", start = 3, end = 0 }
angle = 15

[[seams]]
first = { panel = "back", start = 1, end = 2 }
second = { panel = "front", start = 3, end = 0 }
edges = 9
"""


def written(tmp_path, text: str = TEXT):
    path = tmp_path / "shirt.toml"
    path.write_text(text)
    return path


def test_the_cloth_of_a_file(tmp_path):
    cloth = read_panels(written(tmp_path)).cloth()
    assert cloth.panel_names == ("front", "back")
    np.testing.assert_array_equal(np.diff(cloth.seam_start), [5, 9])  # 8 cm in edges of 1.5 cm, and as given
    np.testing.assert_allclose(cloth.rest_area.sum(), 2 * 12 * 8.25, rtol=1e-12)
    np.testing.assert_allclose(cloth.seam_angle, np.radians([15.0, 0.0]))


def test_the_example_of_the_documentation_is_read(tmp_path):
    from stitchmesh.mixed.cloth import panel_file

    example = "\n".join(line[4:] for line in panel_file.__doc__.splitlines() if line.startswith("    "))
    back = '\n[[panels]]\nname = "back"\noutline = [[0, 0], [50, 0], [50, 60], [0, 60]]\n'
    assert len(read_panels(written(tmp_path, example + back)).panels) == 2


REFUSED = {
    "has no key 'edge_lenght'; did you mean 'edge_length'?": TEXT.replace("edge_length", "edge_lenght"),
    r"panels\[1\] needs 'outline'": TEXT.replace("outline = [[0, 0], [12, 0], [12, 8.5]", "#"),
    r"panels\[0\].outline\[0\]\[0\] is \[0, 0\]; expected a number":
        TEXT.replace("[[0, 0], [12, 0], [12, 8], [0, 8.5]]", "[[[0, 0], [9, 0]], [[1, 1], [2, 2]]]"),
    "panel 'front': outline: sides 0-1 and 2-3: cross or touch":
        TEXT.replace("[12, 8], [0, 8.5]", "[0, 8.5], [12, -8]"),
    "there is no panel 'bag'; the panels are front, back":
        TEXT.replace('panel = "back", start = 3', 'panel = "bag", start = 3'),
    "got end 7; expected a corner from 0 to 3": TEXT.replace("start = 1, end = 2 }\nsecond = { panel = \"back\"",
                                                               "start = 1, end = 7 }\nsecond = { panel = \"back\""),
    r"seam 0 .*: got 6 and 7 edges; expected the same":
        TEXT.replace('name = "front"', 'name = "front"\nside_edges = [8, 6, 8, 9]').replace("angle = 15", "edges = 7"),
    "edge length: got -1": TEXT.replace("edge_length = 1.5", "edge_length = -1"),
    "is no TOML": TEXT + "[[",
}  # fmt: skip


@pytest.mark.parametrize("message", REFUSED)
def test_files_that_are_refused(message, tmp_path):
    with pytest.raises(FileError, match=message) as caught:
        read_panels(written(tmp_path, REFUSED[message])).cloth()
    assert str(caught.value).startswith(str(tmp_path / "shirt.toml")) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "path", sorted((ROOT / "examples" / "mixed" / "panels").glob("*.toml")), ids=lambda path: path.stem
)
def test_the_files_of_the_examples(path):
    cloth = read_panels(path).cloth()
    assert cloth.seam_count >= 1
    stretch = edge_stretch(cloth, cloth.vertices)
    assert 0.5 < stretch.min() and stretch.max() < 2.0  # no triangle begins in a wild shape
