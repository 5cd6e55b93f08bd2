# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Values that users write: a valid value becomes an instance of its type; an error is one line with the key."""

from __future__ import annotations

from typing import Any, Literal

import msgspec
import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.io.checked import DEEPEST, check_value, parse_json, plain_value


class Panel(msgspec.Struct, forbid_unknown_fields=True):
    rows: list[int]
    pattern: str = "rib2x2"


class Garment(msgspec.Struct, forbid_unknown_fields=True):
    mesh: str
    stitch_width: float = 0.8
    panels: list[Panel] = []
    spiral: bool = False
    radius: float | None = None
    fit: Literal["loose", "tight"] | None = None


def test_a_valid_value_has_its_type_and_its_defaults():
    found = check_value({"mesh": "hat.obj", "panels": [{"rows": [1, 2]}]}, Garment)
    assert found == Garment("hat.obj", panels=[Panel([1, 2])])


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ({}, "needs 'mesh'; got nothing"),
        ([], "is []; expected an object"),
        ({"mesh": 3}, "mesh is 3; expected a text"),
        ({"mesh": "m", "stitch_width": "wide"}, 'stitch_width is "wide"; expected a number'),
        ({"mesh": "m", "radius": "thin"}, 'radius is "thin"; expected a number or null'),
        ({"mesh": "m", "stich_width": 1}, "has no key 'stich_width'; did you mean 'stitch_width'? the keys are mesh, "),
        ({"mesh": "m", "colour": 1}, "has no key 'colour'; the keys are mesh, stitch_width"),
        ({"mesh": "m", "panels": [{"rows": [1]}, {"rows": [1, "x"]}]}, 'panels[1].rows[1] is "x"; expected a whole'),
        ({"mesh": "m", "panels": [{"row": [1]}]}, "panels[0] has no key 'row'; did you mean 'rows'? the keys are "),
        ({"mesh": "m", "fit": "wide"}, 'fit is "wide"; expected one of loose, tight'),
        ({"mesh": list(range(99))}, "mesh is [0, 1, 2"),
    ],
)  # fmt: skip
def test_an_invalid_value_gives_a_message_of_one_line(value: Any, message: str):
    with pytest.raises(ParameterError) as caught:
        check_value(value, Garment)
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 160


@pytest.mark.parametrize("depth", [DEEPEST + 1, 100_000])
@pytest.mark.parametrize(("before", "after"), [("[", "]"), ('{"a":', "}")])
def test_a_text_that_is_nested_too_deeply_is_refused(before: str, after: str, depth: int):
    with pytest.raises(ParameterError, match=f"is nested too deeply; expected at most {DEEPEST} lists"):
        parse_json(before * depth + "1" + after * depth)
    assert parse_json(before * DEEPEST + "1" + after * DEEPEST)


@pytest.mark.parametrize("text", ["", "{} {}", '{"a": NaN}', '{"a": 1e400}'])
def test_a_text_that_is_not_json_gives_a_message_of_one_line(text: str):
    with pytest.raises(ParameterError, match=r"^is no JSON .{0,100}$"):
        parse_json(text)


@pytest.mark.parametrize(
    ("given", "plain"),
    [
        (np.array([3, 1]), [3, 1]),
        (np.float32(0.5), 0.5),
        (np.bool_(True), True),
        (np.arange(4).reshape(2, 2), [[0, 1], [2, 3]]),
        ({10, 9, np.int64(8)}, [8, 9, 10]),
        (iter([1, 2]), [1, 2]),
        ({"faces": np.array([1]), "more": {"deep": (1,)}}, {"faces": [1], "more": {"deep": [1]}}),
        ("text", "text"),
    ],
)
def test_numbers_and_collections_become_those_of_json(given: Any, plain: object):
    found = plain_value(given)
    assert found == plain and type(found) is type(plain)
    items = found if isinstance(found, list) else []
    assert all(type(item) in (int, list) for item in items)
