# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Recipes in several sizes: each size reads back to its stitches, repeats are whole, and measures come true."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.editing.edit import Edit
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.hand_knitting import parse_instructions, written_pieces
from stitchmesh.io import read_stitches, write_mesh
from stitchmesh.mesh.courses import find_courses
from stitchmesh.pipeline.garment import Garment
from stitchmesh.pipeline.stage_table import ROWS, STITCHES, run_stages
from stitchmesh.recipe.grade import Graded, grade, write_graded
from stitchmesh.recipe.recipe import Recipe, recipe_options
from stitchmesh.recipe.recipe_file import read_recipe
from stitchmesh.recipe.sections import RecipePattern, RowsSection
from stitchmesh.recipe.sizes import GarmentSize, parse_ease, read_sizes, standard_sizes
from stitchmesh.run import Run
from tests.cli.calls import refused_without_files, run
from tests.gallery import ROOT, tube

TABLE = "size,girth [cm],length [in]\nS,30,4\nM,36.5,5\nL,44,5.5\n"


@pytest.fixture(scope="module")
def recipe(tmp_path_factory) -> Recipe:
    path = tmp_path_factory.mktemp("mesh") / "tube.obj"
    write_mesh(path, tube(8, 3, radius=5.0, height=4.0))
    rib = RecipePattern(pattern="rib2x2", on="hem 5")
    return Recipe(mesh=str(path), quality="draft", device="cpu", stitch_width=0.9, patterns=(rib,))


@pytest.fixture(scope="module")
def hat() -> Graded:
    sizes = [GarmentSize("S", {"head": 50.0, "length": 17.0}), GarmentSize("M", {"head": 60.9, "length": 20.7}),
             GarmentSize("L", {"head": 66.0, "length": 22.0})]  # fmt: skip
    return grade(replace(read_recipe(ROOT / "examples" / "hat.toml"), device="cpu"), sizes)


def fabric_of(recipe: Recipe):
    """The stitches that ``knit`` makes of a recipe."""
    found = recipe.read_mesh()
    garment = Garment.begin(found.mesh, recipe_options(recipe, found.up))
    return run_stages((*ROWS, *STITCHES), garment, lambda stage, made: stage.run(made, Run(None))).fabric


def check_round_trip(graded: Graded) -> None:
    for one in graded.sizes:
        assert parse_instructions(graded.instructions, size=one.size.name) == written_pieces(one.fabric)


def test_each_size_of_the_hat_is_read_back(hat):
    check_round_trip(hat)
    rows = [int(one.fabric.row.max()) for one in hat.sizes]
    assert rows == sorted(set(rows))  # the sizes have other numbers of rows
    assert "Sizes: S (M, L)." in hat.instructions
    assert "Round 10: [A: k1, C: k1] 35 (40, 45) times." in hat.instructions


def test_rounds_of_a_pattern_hold_whole_repeats(hat):
    for one in hat.sizes:
        assert not one.cut
        rounds = [course.faces for course in find_courses(one.fabric) if course.closed]
        # The chart of ten stitches has yarn 1 in these rounds.
        charted = [faces for faces in rounds if (one.fabric.yarn[list(faces)] == 1).any()]
        assert len(charted) >= 5 and {len(faces) % 10 for faces in charted} == {0}


def test_measures_come_true_within_half_a_repeat(hat):
    for one in hat.sizes:
        assert one.finished["head"] == pytest.approx(one.size.measures["head"], abs=0.5 * 10 * 0.76)
        # Whole rows: half a row of 0.585 cm, and the rounding of the printed measure.
        assert one.finished["length"] == pytest.approx(one.size.measures["length"], abs=0.35)
    amounts = [sum(amount.metres for amount in one.amounts) for one in hat.sizes]
    assert amounts == sorted(amounts)


def test_the_measures_of_the_mesh_give_the_stitches_of_the_recipe(hat):
    own = fabric_of(replace(read_recipe(ROOT / "examples" / "hat.toml"), device="cpu"))
    assert written_pieces(hat.sizes[1].fabric) == written_pieces(own)


def test_a_girth_without_a_pattern_comes_true(recipe):
    # 8 equal edges would each be rounded to the same side, by up to half a stitch each.
    sizes = [GarmentSize(f"{girth}", {"girth": float(girth)}) for girth in (26, 28, 33, 35)]
    for one in grade(replace(recipe, patterns=()), sizes).sizes:
        assert one.deviation <= 0.02, one.size  # ALLOWED


def test_a_size_written_to_a_folder_is_knitted_as_graded(recipe, tmp_path):
    graded = grade(recipe, [GarmentSize("S", {"girth": 30.0, "length": 10.0}), GarmentSize("XL", {"girth": 50.0})][:1])
    write_graded(tmp_path, graded)
    again = read_recipe(tmp_path / "S.toml")
    assert written_pieces(fabric_of(again)) == written_pieces(graded.sizes[0].fabric)
    written = read_stitches(tmp_path / "S.h5")
    assert written_pieces(written) == parse_instructions((tmp_path / "instructions.txt").read_text(), size="S")


def test_a_sweater_of_four_pieces_is_read_back():
    sweater = Recipe(mesh=str(ROOT / "assets" / "meshes" / "sweater.obj"), device="cpu", quality="draft",
                     stitch_width=2.2, patterns=(RecipePattern(pattern="rib1x1", on="hem 3 or cuffs 3"),))  # fmt: skip
    # Loose ease, because stitches of 2.2 cm are too large for the measures of a body.
    graded = grade(sweater, "women:S,L,2X", ease=[parse_ease("chest=10"), parse_ease("upper arm=25%")])
    check_round_trip(graded)
    assert set(graded.sizes[0].size.measures) == {"chest", "upper arm", "sleeve length"}
    for one in graded.sizes:
        assert one.finished["chest"] == pytest.approx(one.size.measures["chest"], rel=0.021)  # ALLOWED
    casts = [pieces[0].cast_on for pieces in (written_pieces(one.fabric) for one in graded.sizes)]
    assert casts == sorted(set(casts)) and all(cast % 2 == 0 for cast in casts)


def test_tables_and_ease(tmp_path):
    (tmp_path / "sizes.csv").write_text("\ufeffsize, Upper_Arm (in) ,girth [mm]\n\n S ,10,300\n2-4 y,12.5,365\n")
    small, other = read_sizes(tmp_path / "sizes.csv")
    assert small == GarmentSize("S", {"upper arm": 25.4, "girth": 30.0}) and other.name == "2-4 y"
    assert parse_ease("Girth = -10%").added(small).measures["girth"] == pytest.approx(27.0)
    assert parse_ease("girth=1in").added(small).measures["girth"] == pytest.approx(32.54)
    women = standard_sizes("women", ["chest", "length"])
    assert [size.name for size in women][:3] == ["XS", "S", "M"] and list(women[0].measures) == ["chest"]
    chests = [size.measures["chest"] for size in women]
    assert (np.diff(chests) > 0).all()


@pytest.mark.parametrize(("text", "message"), [
    ("size,girth\nS,30\n", "column 'girth': has no unit; expected one of mm, cm"),
    ("size,girth [ell]\nS,30\n", "column 'girth [ell]': has the unit 'ell'"),
    ("size,girth [cm],girth [in]\nS,30,12\n", "the column 'girth' twice"),
    ("size\nS\n", "got no measures"),
    ("size,girth [cm]\n", "got 1 lines"),
    ("size,girth [cm]\nS,30\nS,31\n", "size S: occurs twice"),
    ("size,girth [cm]\nS,-30\n", "line 2: size S: girth: got -30 cm; expected 1 to 1000 cm"),
    ("size,girth [cm]\nS,nan\n", "line 2: size S: girth: got nan cm"),
    ("size,girth [cm]\nS,\n", "line 2: girth: got ''; expected a length"),
    ("size,girth [cm]\nS,30,4\n", "line 2: got 3 cells; expected 2"),
    ("size,girth [cm]\nS (M),30\n", "line 2: size 'S (M)'"),
    ("size,girth [cm]\n" + "".join(f"{number},30\n" for number in range(31)), "got 31; expected 1 to 30"),
])  # fmt: skip
def test_damaged_tables_are_refused_in_one_line(tmp_path, text, message):
    (tmp_path / "sizes.csv").write_text(text)
    with pytest.raises(FileError) as refused:
        read_sizes(tmp_path / "sizes.csv")
    assert message in str(refused.value) and str(tmp_path) in str(refused.value)


def test_what_holds_for_one_size_only_is_refused(recipe):
    size = [GarmentSize("S", {"girth": 30.0})]
    for change, message in (
        ({"rows": RowsSection(auto=True)}, "auto: sizes need a mesh that is modelled in rows"),
        ({"edits": (Edit("bobble", {"face": 3}),)}, r"edits\[0\]: face: numbers of a fabric differ"),
        ({"stitches": replace(recipe.stitches, counts=("0,1=4",))}, "counts: fix numbers of stitches"),
        ({"patterns": (RecipePattern(pattern="rib1x1", on='file "a.txt"'),)}, r"patterns\[0\].*: a file names faces"),
    ):
        with pytest.raises(ParameterError, match=message):
            grade(replace(recipe, **change), size)
    for sizes, message in (
        ([GarmentSize("S", {"bust": 90.0})], "measure 'bust': this garment does not have it"),
        ([GarmentSize("S", {"girth": 90.0}), GarmentSize("s", {"girth": 91.0})], "differ in capitals only"),
        ([GarmentSize("S", {"girth": 90.0}), GarmentSize("M", {"length": 9.0})], "expected the same measures"),
        ([GarmentSize("S", {"girth": 900.0})], "size S: girth: got 900 cm, but the mesh has"),
        ("people:S", "sizes 'people': is no table"),
        ("women:Q", "size 'Q': is not in the table women"),
        ("feet", "the table states none of the measures of this garment"),
        ([], "got 0; expected 1 to 30"),
    ):
        with pytest.raises(ParameterError, match=message):
            grade(recipe, sizes)
    with pytest.raises(ParameterError, match="ease: 'head' is no measure of the sizes; expected girth"):
        grade(recipe, size, ease=[parse_ease("head=3")])
    for text in ("girth", "girth=", "girth=3ell", "=3", "girth=..", "girth=1e9x"):
        with pytest.raises(ParameterError, match="ease: got"):
            parse_ease(text)


def test_the_command_writes_all_sizes(recipe, tmp_path):
    from stitchmesh.recipe.recipe_file import write_recipe

    (tmp_path / "sizes.csv").write_text(TABLE)
    write_recipe(tmp_path / "tube.toml", recipe)
    words = ["grade", tmp_path / "tube.toml", "--sizes", tmp_path / "sizes.csv", "-o", tmp_path / "out", "--no-picture"]
    run(*words, "--ease", "girth=-1")
    report = json.loads((tmp_path / "out" / "report.json").read_text())["grade"]["sizes"]
    assert list(report) == ["S", "M", "L"] and report["S"]["asked_cm"] == {"girth": 29.0, "length": 10.16}
    assert report["L"]["yarns"][0]["grams"] > report["S"]["yarns"][0]["grams"] > 0
    sizes = {f"{size}.{kind}" for size in "SML" for kind in ("obj", "toml", "h5")}
    made = {path.name for path in (tmp_path / "out").iterdir() if not path.name.startswith(".")}
    assert made == {"instructions.txt", "report.json"} | sizes
    text = (tmp_path / "out" / "instructions.txt").read_text()
    assert parse_instructions(text, size="L") == written_pieces(read_stitches(tmp_path / "out" / "L.h5"))


def test_the_command_refuses_in_one_line(recipe, tmp_path, capsys):
    from stitchmesh.recipe.recipe_file import write_recipe

    write_recipe(tmp_path / "tube.toml", recipe)
    line = refused_without_files(
        capsys, tmp_path / "out", "grade", tmp_path / "tube.toml", "--sizes", "sizes", "-o", tmp_path / "out"
    )
    assert "sizes 'sizes': is no table" in line
