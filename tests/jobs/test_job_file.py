# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Job files: a new one has the defaults, each key is an argument of a public function, and others are refused."""

from __future__ import annotations

import inspect
import tomllib
from dataclasses import fields, replace

import pytest

import stitchmesh as sm
from stitchmesh.cli.main import main
from stitchmesh.errors import FileError
from stitchmesh.io.checked import check_table
from stitchmesh.jobs.job import Job, recipe_of
from stitchmesh.jobs.job_file import example_job, job_of_table, read_job
from stitchmesh.jobs.sections import RenderTable, SwatchTable
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.recipe.recipe import Recipe, recipe_options
from stitchmesh.recipe.recipe_file import write_recipe


def names_of(kind):
    return {part.name for part in fields(kind)}


@pytest.mark.parametrize(
    "source, job",
    [
        ("hat.obj", Job(garment=Recipe(mesh="hat.obj"))),
        ("parts/garment.toml", Job(recipe="parts/garment.toml")),
        ("rib2x2", Job(swatch=SwatchTable(pattern="rib2x2"))),
        ("chart.knit", Job(swatch=SwatchTable(pattern="chart.knit"))),
    ],
)
def test_a_new_file_has_the_defaults(source, job):
    assert job_of_table(tomllib.loads(example_job(source)), "job.toml") == job


def test_every_key_without_a_value_has_a_valid_example():
    """Without its # a line gives a value that the key accepts, except where two keys exclude each other."""
    text = example_job("hat.obj").replace("# error", "#error").replace("auto = false", "auto = true")
    text = text.replace("\n# ", "\n").partition("\n\n")[2]
    job = job_of_table(tomllib.loads(text), "job.toml")
    assert job.within == "8h" and job.garment.stitches.course_height == 0.6 and job.render[0].view == "back"


def test_tables_of_functions_with_options_have_their_names():
    swatch = set(inspect.signature(sm.swatch).parameters) | names_of(SwatchOptions)
    assert names_of(SwatchTable) - {"stiffness", "max_iterations"} <= swatch
    assert names_of(RenderTable) <= set(inspect.signature(sm.render).parameters) | names_of(sm.PictureOptions)


def test_a_job_about_a_mesh_has_the_keys_of_a_recipe():
    recipe = {"mesh": "hat.obj", "stitch_width": 1.2, "finish": {"cast_on": "open"}, "edge_forms": ["hem=fold:5"]}
    job = job_of_table({**recipe, "within": "8h"}, "job.toml")
    assert job == Job(garment=check_table(recipe, Recipe), within="8h")


def test_the_former_keys_of_a_job_reach_the_options_of_the_stages():
    table = {
        "mesh": "hat.obj", "objects": ["shirt"], "layer": "inner",
        "make_spiral": True, "turn_inside_out": True, "quality": "draft",
        "label": {"seeds": [[0, 1]], "flip": [2]},
        "tessellate": {"stitch_width": 1.2, "stitch_height": 0.9, "counts": ["3,4=7"]},
        "apply_pattern": [{"pattern": "rib2x2", "on": "hem 6"}],
        "apply_edit": [{"edit": "stripe", "on": "hem 2", "yarn": 1}],
        "relax_mesh": {"alpha": 0.8}, "generate_yarns": {"yarn_radius": 0.14, "cast_on": "open"},
        "apply_rest_lengths": {"factor": 1.1}, "relax_yarns": {"gravity": [0.0, -981.0, 0.0], "max_iterations": 7},
    }  # fmt: skip
    recipe = recipe_of(job_of_table(table, "job.toml"))
    assert (recipe.objects, recipe.layer) == (("shirt",), "inner")
    options = recipe_options(recipe)
    assert (options.stitch_width, options.stitch_height, options.counts) == (1.2, 0.9, {(3, 4): 7})
    assert (options.seeds, options.flip, options.spiral) == (((0, 1),), (2,), True)
    assert options.patterns[0].pattern.name == "2 x 2 rib" and options.edits[0].name == "stripe"
    assert (options.mesh_relaxation.alpha, options.yarn_radius, options.finish.cast_on) == (0.8, 0.14, "open")
    assert options.relaxation.rest_lengths.factor == 1.1 and len(options.relaxation.terms) == 1
    assert options.quality.max_iterations == 7


def test_the_former_keys_of_found_rows_reach_the_options_of_the_stages():
    mark = {"kind": "border", "points": [[0, 0, 2]], "role": "begin"}
    table = {"stitch_width": 1.2, "stitch_height": 0.9, "up": [1, 0, 0], "multiple": 3, "marks": [mark]}
    recipe = recipe_of(job_of_table({"mesh": "hat.stl", "auto_stitches": table}, "job.toml"))
    options = recipe_options(recipe)
    assert options.shaping is not None and options.shaping == recipe.rows.options()
    assert (options.stitch_width, options.stitch_height) == (1.2, 0.9)
    assert (options.shaping.up, options.shaping.multiple) == ((1.0, 0.0, 0.0), 3)
    assert [one.role for one in options.shaping.marks] == ["begin"]


@pytest.mark.parametrize(
    "table, message",
    [
        ({"mehs": "a.obj"}, "has no key 'mehs'; did you mean 'mesh'?"),
        ({"mesh": "a.obj", "tessellate": {"stich_width": 1}}, "tessellate has no key 'stich_width'; did you mean"),
        ({"swatch": {"pattern": "rib2x2", "gama": 1.0}}, "did you mean 'gamma'?"),
        ({"swatch": {"gamma": 1.0}}, "swatch needs 'pattern'"),
        ({"mesh": "a.obj", "tessellate": {"stitch_width": "wide"}}, 'stitch_width is "wide"; expected a number'),
        ({"mesh": "a.obj", "stitch_width": 1, "tessellate": {"stitch_width": 2}},
         "tessellate.stitch_width: is the former name of stitch_width, which is given too; leave one of the two out"),
        ({"mesh": "a.obj", "tessellate": 3}, "tessellate is 3; expected a table"),
        ({}, "got none of them; expected one of mesh, recipe and"),
        ({"mesh": "a.obj", "recipe": "b.toml"}, "got mesh and recipe"),
        ({"swatch": {"pattern": "rib2x2"}, "tessellate": {"stitch_width": 1.0}},
         "stitch_width: is no key of a job with a swatch; leave it out"),
        ({"recipe": "b.toml", "auto_stitches": {}}, "rows: is no key of a job with a recipe; write it into"),
        ({"mesh": "a.obj", "quality": "fine"}, "quality: got 'fine'; expected one of draft"),
        ({"mesh": "a.obj", "within": "soon"}, "within: got the text 'soon'"),
        ({"mesh": "a.obj", "quality": "draft", "error": "1%"}, "error: got a quality"),
        ({"mesh": "a.obj", "write_yarns": ["../yarns.h5"]}, "got '../yarns.h5'; expected a file in the folder"),
        ({"mesh": "a.obj", "write_yarns": ["yarns.png"]}, "one of the suffixes .h5"),
        ({"mesh": "a.obj", "render": [{"path": "/tmp/a.png"}]}, "render: got '/tmp/a.png'"),
        ({"mesh": "a.obj", "render": [{"view": "abvoe"}]}, "abvoe"),
        ({"mesh": "a.obj", "relax_yarns": {"checkpoint_every": 0}}, "checkpoint every: got 0"),
        ({"mesh": "a.obj", "auto_stitches": {"multiple": 0}}, "multiple: got 0; expected 1 or more stitches"),
        ({"mesh": "a.obj", "apply_edit": [{"yarn": 1}]}, "edits[0] needs 'edit'"),
    ],
)  # fmt: skip
def test_what_no_job_has_is_refused(table, message):
    with pytest.raises(FileError) as caught:
        job_of_table(table, "job.toml")
    assert str(caught.value).startswith("job.toml: ") and message in str(caught.value)


def test_a_recipe_keeps_its_relaxation(tmp_path):
    write_recipe(tmp_path / "garment.toml", Recipe(mesh="hat.obj", quality="draft"))
    job = Job(recipe=str(tmp_path / "garment.toml"), quality="reference")
    assert recipe_of(replace(job, checkpoint_every=9)).quality == "reference"


def test_paths_are_relative_to_the_file(tmp_path):
    (tmp_path / "job.toml").write_text(
        'mesh = "hat.obj"\n[relax_yarns]\nbody = "body.obj"\n[[apply_pattern]]\npattern = "a.knit"\n'
    )
    job = read_job(tmp_path / "job.toml")
    assert [job.garment.mesh, job.garment.physics.body, job.garment.patterns[0].pattern] == [
        str(tmp_path / name) for name in ("hat.obj", "body.obj", "a.knit")
    ]


PROJECTS = {
    "mesh": 'mesh = "{}.obj"\n',
    "body": 'mesh = "own.obj"\n[relax_yarns]\nbody = "{}.obj"\n',
    "pattern": 'mesh = "own.obj"\n[[apply_pattern]]\npattern = "{}.knit"\n',
    "selection": 'mesh = "own.obj"\n[[apply_pattern]]\npattern = "rib2x2"\non = \'hem 2 and file "{}.txt"\'\n',
    "edit": 'mesh = "own.obj"\n[[apply_edit]]\nedit = "stripe"\nyarn = 1\non = \'file "{}.txt"\'\n',
    "chart": '[swatch]\npattern = "{}.png"\n',
    "recipe": 'recipe = "{}.toml"\n',
}
"""Jobs with one place for the path of a file without its suffix."""


@pytest.mark.parametrize("text", PROJECTS.values(), ids=PROJECTS)
def test_files_outside_the_project_are_refused(text, tmp_path):
    """Files are in the folder of the job, in the present one or in an allowed one; links count as their target."""
    project, other = tmp_path / "project", tmp_path / "other"
    for folder in (project / "parts", other):
        folder.mkdir(parents=True)
        write_recipe(folder / "file.toml", Recipe(mesh="assets/meshes/hat.obj"))  # in the present folder
    (project / "link").symlink_to(other)
    job = project / "job.toml"
    for outside in ("../other/file", "link/file", str(other / "file"), "parts/../../other/file"):
        job.write_text(text.format(outside))
        with pytest.raises(FileError, match="outside the project") as caught:
            read_job(job)
        message = str(caught.value)
        assert message.startswith(f"{job}: names {other}/file.") and message.endswith(f"--allow-paths {other}")
        read_job(job, allow_paths=[other])
    for inside in ("parts/file", "../project/parts/file", str(project / "parts" / "file")):
        job.write_text(text.format(inside))
        read_job(job)


def test_files_that_a_recipe_of_a_job_names_are_in_the_project_too(tmp_path):
    (tmp_path / "project").mkdir()
    write_recipe(tmp_path / "project" / "garment.toml", Recipe(mesh=str(tmp_path / "hat.obj")))
    (tmp_path / "project" / "job.toml").write_text('recipe = "garment.toml"\n')
    with pytest.raises(FileError, match=r"garment.toml: names .*/hat.obj, which is outside the project"):
        read_job(tmp_path / "project" / "job.toml")
    assert read_job(tmp_path / "project" / "job.toml", allow_paths=[tmp_path]).recipe is not None


def test_init_writes_a_job_that_runs_from_its_folder(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)  # the mesh is above the folder of the job, and so has to be in the present one
    path = tmp_path / "parts" / "job.toml"
    assert main(["job", "init", str(tmp_path / "hat.obj"), "-o", str(path)]) == 0
    assert "stitchmesh run" in capsys.readouterr().out
    assert read_job(path).garment.mesh == str(tmp_path / "parts" / ".." / "hat.obj")
    assert main(["job", "init", "rib2x2", "-o", str(path)]) == 2
    assert "is there already" in capsys.readouterr().err
    assert main(["job", "init", str(tmp_path), "-o", str(tmp_path / "job.toml")]) == 2
    assert "is a folder; expected a mesh" in capsys.readouterr().err and not (tmp_path / "job.toml").exists()
