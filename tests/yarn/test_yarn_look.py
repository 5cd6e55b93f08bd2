# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Looks of yarns: presets, their bounds, and their files."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.yarn_files import read_yarn, write_yarn
from stitchmesh.yarn.yarn_description import YarnDescription, described_yarn
from stitchmesh.yarn.yarn_look import YarnLook, look_names
from stitchmesh.yarn.yarn_presets import Yarn, format_yarn, parse_yarn

SPUN = {"linear_density": "72 tex", "diameter": "0.4 mm", "axial_stiffness": "5 N", "bending_rigidity": "0.01 cN cm2"}


@pytest.mark.parametrize("name", look_names())
def test_every_preset_says_what_it_rests_on(name: str) -> None:
    look = YarnLook(name)
    assert look.source and look.name == name


def test_a_field_changes_and_the_others_stay_those_of_the_preset() -> None:
    changed, preset = YarnLook("mohair", hair_length=6.0), YarnLook("mohair")
    assert changed.hair_length == 6.0 and replace(changed, hair_length=preset.hair_length) == preset


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"name": "mohar"}, "look: got 'mohar'; expected mohair"),
        ({"plies": 0}, "look: plies is 0; expected a whole number from 1 to 8"),
        ({"plies": 2.5}, r"look: plies is 2\.5; expected a whole number"),
        ({"lay": float("nan")}, "look: lay is nan; expected a number from 1 to 10000"),
        ({"twist": "z"}, "look: twist is 'z'; expected S or Z"),
        ({"marl": ("own", "crem")}, "look: marl: colour: got 'crem'.*or own"),
        ({"neps": 0.1}, "look: got neps without nep_colours"),
    ],
)
def test_what_is_out_of_bounds_is_refused(fields: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        YarnLook(**fields)


def test_the_text_of_a_yarn_keeps_its_look() -> None:
    yarn = replace(Yarn.named("dk"), look=YarnLook("wool", marl=("own", "navy"), plies=2))
    assert parse_yarn(format_yarn(yarn)) == yarn


def test_the_text_of_an_earlier_version_has_the_default_look() -> None:
    import json

    values = json.loads(format_yarn(Yarn.named("dk")))
    del values["look"]
    assert parse_yarn(json.dumps(values)).look == YarnLook()


@pytest.mark.parametrize("look", ["mohair", YarnLook("wool", plies=2, marl=("own", "navy"))])
def test_yarn_toml_holds_a_name_or_the_fields(look: str | YarnLook, tmp_path: Path) -> None:
    write_yarn(tmp_path / "yarn.toml", YarnDescription(**SPUN, look=look))
    assert read_yarn(tmp_path / "yarn.toml").look == (YarnLook(look) if isinstance(look, str) else look)


def test_a_table_of_yarn_toml_changes_a_preset(tmp_path: Path) -> None:
    lines = [f'{key} = "{value}"' for key, value in SPUN.items()]
    (tmp_path / "yarn.toml").write_text("\n".join([*lines, "[look]", 'name = "silk"', "hair_length = 2"]))
    assert read_yarn(tmp_path / "yarn.toml").look == YarnLook("silk", hair_length=2)
    (tmp_path / "yarn.toml").write_text("\n".join([*lines, "[look]", 'name = "silk"', "hairs = 2"]))
    with pytest.raises(FileError, match="look has no key 'hairs'"):
        read_yarn(tmp_path / "yarn.toml")


def test_a_described_yarn_looks_like_its_fibre() -> None:
    described = {"linear_density": "20 tex", "diameter": "0.15 mm", "tensile_modulus": "3 GPa"}
    assert described_yarn(**described, fibre="cotton", fibre_diameter="12 um").look == YarnLook("cotton")
    assert described_yarn(**described, fibre="nylon", fibre_diameter="0.15 mm").look == YarnLook("monofilament")
    assert described_yarn(**described, fibre="viscose", fibre_diameter="12 um").look == YarnLook()
