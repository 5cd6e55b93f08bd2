# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Dataclasses as TOML files."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.errors import FileError
from stitchmesh.io.toml_file import changed_fields, read_dataclass, table_lines


@dataclass(frozen=True)
class Place:
    x: float = 0.0
    y: float = 0.0


@dataclass(frozen=True)
class Thing:
    name: str = ""
    size: float = 1.0
    closed: bool = False
    places: tuple[Place, ...] = ()
    at: Place = field(default_factory=Place)


def text_of(thing: Thing, **options: object) -> str:
    return "\n".join(table_lines(changed_fields(thing), **options)) + "\n"


@pytest.mark.parametrize("inline", [(), ("at",)])
def test_a_dataclass_comes_back_from_its_file(tmp_path: Path, inline: tuple[str, ...]) -> None:
    thing = Thing('a "name"\x7f\n', float("inf"), True, (Place(1.0), Place(y=-2.5)), Place(0.1, 0.2))
    path = tmp_path / "thing.toml"
    path.write_text(text_of(thing, inline=inline), encoding="utf-8")
    assert read_dataclass(path, Thing) == thing


def test_defaults_are_left_out_and_numbers_of_numpy_are_numbers() -> None:
    assert text_of(Thing()) == "\n"
    assert tomllib.loads(text_of(Thing(size=np.float64(0.1)))) == {"size": 0.1}


def test_a_comment_stands_at_the_first_place_of_its_key() -> None:
    lines = text_of(Thing(places=(Place(1.0), Place(2.0))), comments={"places.x": "[cm]"}).splitlines()
    assert [line for line in lines if line.startswith("x")] == ["x = 1.0  # [cm]", "x = 2.0"]


@pytest.mark.parametrize(
    ("text", "message"),
    [("", "the file is empty"), ("size = ", "is no TOML"), ("a = " + "[" * 5000, "nested|TOML"),
     ("a." * 5000 + "b = 1", "keys of very many parts"),
     ("\n".join(f"a{number}{'.b' * 300} = 1" for number in range(20)), "keys of very many parts"),
     ("sise = 1.0", "did you mean 'size'"), ("size = 'x'", "size")],
)  # fmt: skip
def test_bad_files_are_refused_in_one_line(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "thing.toml"
    path.write_text(text)
    with pytest.raises(FileError, match=message) as caught:
        read_dataclass(path, Thing)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)
