# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Values as a user of Python meets them: one line says what a value is, or why a function does not take it."""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.editing.edit import apply_edit
from stitchmesh.errors import FileError, LabelError, ParameterError, PatternError, check_kind
from stitchmesh.periodic.stretch import StretchCurve
from stitchmesh.pipeline.knit import Knitted
from stitchmesh.yarnrelax import Relaxation, RelaxedCell, RelaxedCells
from tests.gallery import tube

RELAXATION = {"converged": True, "iterations": 140, "residual": 0.00712, "wales": 2, "courses": 1, "width": 1.0,
              "height": 0.7}  # fmt: skip


@cache
def values() -> dict[str, object]:
    """One value of each class that functions take and return; none of them needs a relaxation."""
    mesh = tube(8, 2, radius=2.0, height=1.5)
    labeled = sm.label(mesh)
    fabric = sm.tessellate(labeled, stitch_width=1)
    yarns = sm.generate_yarns(fabric, quality="draft")
    cell = sm.weave_yarns(sm.read_weave("plain"), yarn_radius=0.1, quality="draft")
    return {
        "mesh": mesh,
        "labeled": labeled,
        "fabric": fabric,
        "yarns": yarns,
        "cell": cell,
        "lattice": cell.lattice,
        "pattern": sm.read_pattern("lice"),
        "weave": sm.read_weave("plain"),
        "edited": apply_edit(fabric, sm.Edit("stripe", {"faces": [3], "yarn": 1})),
        "swatch": sm.Swatch(cell, RELAXATION, None, []),
        "relaxation": Relaxation(yarns, RELAXATION, []),
        "knitted": Knitted(fabric, yarns, RELAXATION, []),
        "cells": RelaxedCells([RelaxedCell(cell, RELAXATION, [])], {"converged": 1}),
        "textures": sm.texture_maps(cell, width=4),
        "yarn": sm.Yarn.named("dk"),
        "material": sm.YarnMaterial.named(),
        "text": "hat.obj",
        "number": 3,
        "nothing": None,
        "list": [1, 2],
        "array": np.zeros((2, 3)),
    }


KINDS = (
    "mesh", "labeled", "fabric", "yarns", "cell", "lattice", "pattern", "weave", "edited", "swatch", "relaxation",
    "knitted", "cells", "textures", "yarn", "material", "text", "number", "nothing", "list", "array",
)  # fmt: skip
"""The keys of ``values``."""
MESHES = {"mesh", "labeled", "fabric"}
FABRICS = {"labeled", "fabric"}
YARNS = {"yarns", "cell"}
NAMES = {"text"}
TAKES = {
    "label": (sm.label, MESHES),
    "tessellate": (lambda value: sm.tessellate(value, stitch_width=1.0), FABRICS),
    "relax_mesh": (lambda value: sm.relax_mesh(value, surface=values()["mesh"]).fabric, FABRICS),
    "relax_mesh surface": (lambda value: sm.relax_mesh(values()["fabric"], surface=value).fabric, MESHES),
    "generate_yarns": (sm.generate_yarns, FABRICS),
    "regenerate_yarns": (lambda value: sm.regenerate_yarns(value, values()["fabric"], values()["fabric"]), YARNS),
    "check_loops": (lambda value: sm.check_loops(value, values()["yarns"]), FABRICS),
    "relax_yarns": (sm.relax_yarns, YARNS),
    "relax_yarns material": (lambda value: sm.relax_yarns(values()["yarns"], material=value), {"material", "nothing"}),
    "relax_yarns shape": (lambda value: sm.relax_yarns(values()["yarns"], keep_shape=value), {*FABRICS, "nothing"}),
    "relax_yarns quality": (lambda value: sm.relax_yarns(values()["yarns"], quality=value), set()),
    "relax_cells": (lambda value: sm.relax_cells([value]), YARNS),
    "yarn_energies": (lambda value: sm.yarn_energies(value, sm.YarnMaterial.named()), YARNS),
    "yarn_forces material": (lambda value: sm.yarn_forces(values()["yarns"], value), {"material"}),
    "linking_certificate": (sm.linking_certificate, YARNS),
    "apply_edit": (lambda value: sm.apply_edit(value, sm.Edit("spiral")), FABRICS),
    "apply_edit edit": (lambda value: sm.apply_edit(values()["fabric"], value), set()),
    "Edit": (lambda value: sm.Edit("stripe", value), set()),
    "History": (sm.History, FABRICS),
    "select": (lambda value: sm.select(value, "rows 1"), FABRICS),
    "apply_pattern": (lambda value: sm.apply_pattern(value, "rib2x2"), FABRICS),
    "apply_pattern pattern": (lambda value: sm.apply_pattern(values()["fabric"], value), {"pattern"}),
    "start_labeling": (sm.start_labeling, MESHES),
    "make_spiral": (sm.make_spiral, FABRICS),
    "knitting_instructions": (sm.knitting_instructions, FABRICS),
    "apply_rest_lengths": (lambda value: sm.apply_rest_lengths(value, sm.RestLengths()), YARNS),
    "apply_rest_lengths change": (lambda value: sm.apply_rest_lengths(values()["yarns"], value), set()),
    "estimate_radius": (sm.estimate_radius, YARNS),
    "tile_yarns": (lambda value: sm.tile_yarns(value, 2, 2), YARNS),
    "texture_maps": (lambda value: sm.texture_maps(value, width=4), YARNS),
    "torus_mesh": (lambda value: sm.torus_mesh(value, stitch_width=1.0, stitch_height=1.0), {"pattern"}),
    "pattern_mesh": (lambda value: sm.pattern_mesh(value, stitch_width=1.0, stitch_height=1.0), {"pattern"}),
    "weave_yarns": (lambda value: sm.weave_yarns(value, yarn_radius=0.1), {"weave"}),
    "swatch": (sm.swatch, {"pattern", "weave"}),
    "swatch material": (lambda value: sm.swatch("plain", material=value), {"material", "nothing"}),
    "parse_pattern": (sm.parse_pattern, NAMES),
    "read_pattern": (sm.read_pattern, set()),
    "read_weave": (sm.read_weave, set()),
    "read_mesh": (sm.read_mesh, set()),
    "read_stitches": (sm.read_stitches, set()),
    "read_yarns": (sm.read_yarns, set()),
    "write_yarns path": (lambda value: sm.write_yarns(value, "yarns.bcc"), set()),
}
"""Calls with one argument of any class, and the values that are of the right class. A text as the name of a file, of a
material or of a quality is no wrong kind, but here it names nothing, which is an error too."""
ANSWERS = r"got |expected |is not in the library|unknown format|no such file|no suffix"
"""A message holds one of these."""


@pytest.mark.parametrize("name", TAKES)
def test_a_value_of_the_wrong_kind_gives_a_message_of_one_line(name):
    function, right = TAKES[name]
    for given in (given for given in KINDS if given not in right):
        with pytest.raises(sm.StitchMeshError) as caught:
            function(values()[given])
        message = str(caught.value)
        assert "\n" not in message and len(message) < 250, given
        assert re.search(ANSWERS, message), message


@pytest.mark.parametrize(("write", "right"), [("mesh", MESHES), ("stitches", FABRICS), ("yarns", YARNS)])
def test_nothing_of_the_wrong_kind_is_written(tmp_path, write, right):
    path = tmp_path / ("out.obj" if write == "mesh" else "out.h5")
    for given in values():
        if given not in right:
            with pytest.raises(ParameterError, match=f"^write_{write}: got .*; expected a"):
                getattr(sm, f"write_{write}")(path, values()[given])
            assert not path.exists()


@pytest.mark.parametrize(
    ("given", "kind", "made_by", "message"),
    [
        ("mesh", sm.StitchMesh, "sm.label(mesh)", "got a Mesh; expected a StitchMesh: make one by sm.label(mesh)"),
        ("fabric", sm.YarnSet, None, "got a StitchMesh; expected a YarnSet: make one by sm.generate_yarns(fabric)"),
        ("text", sm.Mesh, None, "got the text 'hat.obj'; expected a Mesh: make one by sm.read_mesh(path)"),
        ("array", sm.Mesh, None, "got an array of shape (2, 3); expected a Mesh: make one by sm.read_mesh(path)"),
        ("relaxation", sm.YarnSet, None, "got a Relaxation; expected a YarnSet: give its field 'yarns'"),
        ("edited", sm.StitchMesh, None, "got an Edited; expected a StitchMesh: give its field 'fabric'"),
    ],
)
def test_a_message_says_what_was_got_and_the_call_that_makes_what_is_expected(given, kind, made_by, message):
    with pytest.raises(ParameterError) as caught:
        check_kind("stage", values()[given], kind, made_by)
    assert str(caught.value) == f"stage: {message}"


def test_the_call_in_a_message_makes_what_is_expected():
    """Each call of a message is a public function, and what it makes passes the check."""
    from stitchmesh.errors import MAKERS

    for kind, call in MAKERS.items():
        function = getattr(sm, call.removeprefix("sm.").split("(")[0].split(".")[0])
        assert callable(function), kind
    assert check_kind("stage", values()["mesh"], sm.Mesh) is values()["mesh"]


@pytest.mark.parametrize("name", [name for name in KINDS if name not in ("list", "array")])
def test_every_value_is_one_line(name):
    assert set(values()) == set(KINDS)
    shown = repr(values()[name])
    assert "\n" not in shown and len(shown) < 260 and "array(" not in shown


def test_a_line_counts_what_the_value_holds():
    assert repr(values()["labeled"]) == "StitchMesh(16 panels in 2 rows, 4.0 x 3.0 x 4.0 cm)"
    assert repr(values()["pattern"]) == "Pattern('Lice', 6 loops x 4 rows)"
    fabric = "StitchMesh(64 stitches in 4 rows, 4.0 x 3.0 x 4.0 cm)"
    assert repr(values()["edited"]) == f"Edited(1 changes, {fabric})"


def test_yarns_show_their_number_length_radius_and_lattice():
    yarns, cell = values()["yarns"], values()["cell"]
    counts = f"{yarns.yarn_count} yarns, {len(yarns.points)} control points, {yarns.rest_length.sum() / 100:.1f} m"
    assert repr(yarns).startswith(f"YarnSet({counts}, radius ") and "periodic" not in repr(yarns)
    assert repr(cell).endswith(", periodic)") and "radius 0.1 cm" in repr(cell)
    assert repr(values()["relaxation"]).startswith("Relaxation(at rest after 140 iterations, residual 0.0071, YarnSet(")


def test_a_stretch_curve_is_one_line():
    point = type("Point", (), {"strain": 0.25})()
    curve = StretchCurve("course", "free", values()["swatch"], (point, point), ())
    assert repr(curve) == "StretchCurve(course, 2 strains from 0.25 to 0.25, the other free)"


def test_what_an_error_quotes_does_not_break_its_line_or_make_it_long():
    quoted = FileError(f"y.pyp: got {'x' * 10**6}\nand\u2028more \x1b[31m; expected numbers")
    text = str(quoted)
    assert len(text.splitlines()) == 1 and text.isprintable() and len(text) < 2000
    assert text.startswith("y.pyp: got xxx") and text.endswith("\N{REPLACEMENT CHARACTER}[31m; expected numbers")
    assert str(PatternError("a\nb", line=3)) == "a b" and str(LabelError("plain")) == "plain"
