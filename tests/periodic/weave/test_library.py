# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The library of weaves: each weave agrees with its name; weaves as images of two colours.

An image is light where the weft passes over and dark where the warp does.
"""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from PIL import Image

from stitchmesh.errors import FileError, ParameterError, PatternError
from stitchmesh.periodic.weave.library import read_weave, weave_names
from tests.periodic.weave.test_weave import stitching

SINGLE_LAYER = {
    "plain": (2, lambda i, j: (i + j) % 2 == 1),
    "basket-2x2": (4, lambda i, j: (i // 2 + j // 2) % 2 == 1),
    "basket-3x3": (6, lambda i, j: (i // 3 + j // 3) % 2 == 1),
    "twill-2x1": (3, lambda i, j: (j - i) % 3 < 2),
    "twill-3x2": (5, lambda i, j: (j - i) % 5 < 3),
    "twill-4x1": (5, lambda i, j: (j - i) % 5 < 4),
    "satin-2x3": (5, lambda i, j: (j - 2 * i) % 5 < 2),
    "satin-3x2": (5, lambda i, j: (j - 2 * i) % 5 < 3),
}
"""Size of the repeat, and whether weft i passes over warp j, for the eight weaves of Leaf et al. 2018, table 3."""
LAYERED = {"double-plain-stitched": 2, "triple-plain-stitched": 3, "orthogonal-interlock": 3}
"""Number of layers of each weave with several layers."""
LINEN, INDIGO, WHITE, BLACK = (240, 230, 200), (20, 30, 90), (255, 255, 255), (0, 0, 0)


@pytest.mark.parametrize("name", SINGLE_LAYER)
def test_weaves_agree_with_their_formulas(name):
    size, weft_is_over = SINGLE_LAYER[name]
    wefts, warps = np.indices((size, size))
    assert np.array_equal(read_weave(name).over, weft_is_over(wefts, warps))


def test_every_weave_is_known_and_has_a_name_and_a_source():
    assert set(weave_names()) == {*SINGLE_LAYER, *LAYERED, "double-cloth-exchanging"}
    for name in weave_names():
        assert read_weave(name).source and read_weave(name).name != f"{name}.weave"


@pytest.mark.parametrize("name", LAYERED)
def test_layers_are_stitched(name):
    weave = read_weave(name)
    assert weave.layer_count == LAYERED[name]
    assert len(stitching(weave)) >= LAYERED[name] - 1


def test_layers_exchange_in_a_checked_pattern():
    """Seen from the back, the checks have exchanged colours: each set of yarns lies in front in half of the checks."""
    over = read_weave("double-cloth-exchanging").over
    first_in_front = over[0::2, 1::2]
    assert first_in_front[:4, :4].all() and not first_in_front[:4, 4:].any()
    assert np.array_equal(over[1::2, 0::2], ~first_in_front)


def test_wrong_names_and_paths_are_refused(tmp_path):
    with pytest.raises(ParameterError, match=r"'satin2x3': is not in the library of \d+ weaves; did you mean satin"):
        read_weave("satin2x3")
    with pytest.raises(FileError, match=r"none\.weave: there is no such file"):
        read_weave(tmp_path / "none.weave")
    (tmp_path / "cloth.weave").write_text("01\n12\n")
    with pytest.raises(PatternError, match=r"cloth\.weave: line 2, column 2: got '2'"):
        read_weave(tmp_path / "cloth.weave")


def painted(over: np.ndarray, light: tuple = WHITE, dark: tuple = BLACK) -> Image.Image:
    return Image.fromarray(np.where(over[:, :, None], light, dark).astype(np.uint8))


@pytest.mark.parametrize("name", ["twill-3x2", "double-cloth-exchanging"])
def test_an_image_of_a_matrix_is_read_as_that_matrix(name, tmp_path):
    weave = read_weave(name)
    painted(weave.over).save(tmp_path / "cloth.png")
    read = read_weave(tmp_path / "cloth.png")
    assert read.matrix == weave.matrix
    assert read.name == "cloth"


@pytest.mark.parametrize("mode", ["1", "P", "RGBA"])
def test_all_kinds_of_png_give_the_same_weave(mode, tmp_path):
    weave = read_weave("twill-2x1")
    painted(weave.over).convert(mode).save(tmp_path / "cloth.png")
    assert read_weave(tmp_path / "cloth.png").matrix == weave.matrix


def test_of_any_two_colours_the_lighter_is_the_weft(tmp_path):
    weave = read_weave("satin-2x3")
    painted(weave.over, light=LINEN, dark=INDIGO).save(tmp_path / "cloth.png")
    assert read_weave(tmp_path / "cloth.png").matrix == weave.matrix


def test_images_that_show_no_weave_are_refused(tmp_path):
    path = tmp_path / "cloth.png"
    picture = painted(read_weave("plain").over)
    picture.putpixel((1, 1), (128, 128, 128))
    picture.save(path)
    with pytest.raises(PatternError, match=r"g: pixel 2 from the left in row 2 from the top: got a third colour"):
        read_weave(path)
    Image.new("L", (3, 3), 255).save(path)
    with pytest.raises(PatternError, match=r"cloth\.png: got one colour; expected light pixels"):
        read_weave(path)
    painted(read_weave("plain").over, light=(255, 0, 0), dark=(0, 255, 0)).save(path)
    with pytest.raises(PatternError, match="got two colours that are equally light"):
        read_weave(path)
    painted(np.array([[1, 1], [1, 0]], dtype=bool)).save(path)
    with pytest.raises(PatternError, match=r"cloth\.png: weave: weft 1 passes over every warp"):
        read_weave(path)
    path.write_text("01\n10\n")
    with pytest.raises(FileError, match=r"cloth\.png: is not a whole PNG"):
        read_weave(path)


def test_the_largest_weave_takes_a_few_numbers_for_each_pixel_and_not_a_cell(tmp_path):
    path = tmp_path / "cloth.png"
    painted(np.add.outer(np.arange(1000), np.arange(1000)) % 2 == 1).convert("1").save(path)
    read_weave("plain")
    tracemalloc.start()
    assert len(read_weave(path).matrix) == 1000
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # The check that the weave hangs together holds seven numbers of eight bytes for each crossing.
    assert most < 64 * 10**6


@pytest.mark.parametrize("size", [(10_001, 1)])
def test_images_with_a_side_that_no_chart_has_are_refused(tmp_path, size):
    path = tmp_path / "cloth.png"
    Image.new("1", size).save(path)
    with pytest.raises(FileError, match=rf"cloth\.png: has {size[0]} x {size[1]} pixels; expected sides of 10000 at"):
        read_weave(path)
