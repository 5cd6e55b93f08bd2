# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A project holds what the library returns, drops what depends on a change, and comes back from disk as it was."""

from __future__ import annotations

import json

import numpy as np
import pytest

from stitchmesh.app.project.division import Division, division_of, division_table
from stitchmesh.app.project.project import Project
from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.errors import FileError, ParameterError, StitchMeshError
from stitchmesh.io.stitches import write_stitches
from stitchmesh.io.yarns import write_yarns
from stitchmesh.labeling import label, start_labeling, write_labeling
from stitchmesh.labeling.steps import LabelStep
from stitchmesh.tessellate import tessellate
from tests.app.project.projects import (
    COARSE,
    HISTORY,
    LABEL_ALL,
    PURL,
    REPORT,
    YARNS,
    divided_project,
    relaxed_project,
    same,
    same_project,
)
from tests.gallery import tube


def test_the_stages_hold_what_the_library_returns(tmp_path):
    project = divided_project(tmp_path)
    labeled = label(tube(12, 4))
    fabric = tessellate(labeled, stitch_width=1.0)
    assert same(project.labeled, labeled) and same(project.fabric, fabric)
    project.apply_edit(PURL)
    assert same(project.fabric, apply_edit(fabric, PURL).fabric)
    assert same(list(project.last_changes), list(apply_edit(fabric, PURL).changes))


def test_a_project_comes_back_as_it_was(tmp_path):
    project = relaxed_project(tmp_path)
    project.apply_edit(Edit("change_stitch", {"faces": [40], "stitch": "p"}))
    project.set_evened(project.fabric)
    project.undo()
    project.set_settings("Label", {"arrows": True, "sizes": [1, 2.5]})
    project.close()
    again = Project.open(tmp_path)
    assert same_project(project, again) and again.notes == ()
    assert again.settings("Label") == {"arrows": True, "sizes": [1, 2.5]}
    assert again.relaxed is not None
    assert again.redo() == ("yarns", "relaxed yarns")
    assert again.edits[-1].arguments["faces"] == [40]
    again.close()


def test_each_change_drops_what_depends_on_it_and_says_so(tmp_path):
    project = relaxed_project(tmp_path)
    assert project.set_yarns(YARNS, {}) == ("relaxed yarns",)
    assert project.set_evened(project.fabric) == ("yarns",)
    assert project.apply_edit(PURL) == ("evened stitches",)
    assert project.divide(COARSE) == ("edits",)
    assert project.apply_label_step(LabelStep("flip_row", {"face": 0})) == ("stitches",)
    assert project.fabric is None and project.division is None
    project.close()


def test_colours_drop_no_result(tmp_path):
    """The yarns of a tube are rings, so that stripes of whole rows are colours only."""
    project = relaxed_project(tmp_path)
    points = project.relaxed.points
    for edit in (Edit("recolour", {"yarn": 0, "colour": "navy"}), Edit("stripe", {"yarn": 2, "rows": [1, 2]})):
        assert project.apply_edit(edit) == ()
        for fabric in (project.evened, project.yarns, project.relaxed):
            assert np.array_equal(fabric.palette, project.fabric.palette)
        assert np.array_equal(project.evened.yarn, project.fabric.yarn)
        assert project.relaxed.points is points and project.report == REPORT
    assert project.undo() == project.undo() == ()
    assert same(project.relaxed, YARNS)
    assert project.apply_edit(Edit("stripe", {"yarn": 1, "faces": [30]})) == (
        "evened stitches", "yarns", "relaxed yarns"
    )  # fmt: skip
    project.close()


def test_undo_and_redo_of_edits_and_of_steps_bring_the_results_back(tmp_path):
    project = relaxed_project(tmp_path)
    fabric, relaxed = project.fabric, project.relaxed
    assert project.undo() == ("evened stitches", "yarns", "relaxed yarns")
    assert project.relaxed is None and project.edit_history.future and not project.edit_history.past
    project.redo()
    assert project.relaxed is relaxed and project.report == REPORT and project.history == HISTORY
    project.apply_label_step(LabelStep("flip_row", {"face": 0}))
    project.undo_label()
    assert same(project.fabric, fabric) and project.edits == (PURL,) and project.relaxed is YARNS
    project.redo_label()
    assert project.fabric is None and len(project.label_steps) == 2
    project.close()


def test_what_a_division_dropped_can_be_restored(tmp_path):
    project = relaxed_project(tmp_path)
    fabric = project.fabric
    project.divide(Division(stitch_width=2.0))
    assert project.can_restore == ("stitches", "edits", "evened stitches", "yarns", "relaxed yarns")
    project.restore()
    assert same(project.fabric, fabric) and project.relaxed is YARNS
    project.restore()
    assert project.division == Division(stitch_width=2.0) and project.relaxed is None
    project.close()


REFUSED = [
    (lambda project: project.apply_edit(Edit("change_stitch", {"faces": [10**6], "stitch": "p"})), "face 1000000"),
    (lambda project: project.apply_label_step(LabelStep("flip_row", {"face": -3})), "face -3"),
    (lambda project: project.divide(Division(stitch_width=-1.0)), "stitch width"),
    (lambda project: project.import_mesh("broken.obj", b"f 1 2 3\n"), "broken.obj"),
    (lambda project: project.import_mesh("empty.obj", b""), "empty.obj: the file is empty"),
    (lambda project: project.import_mesh("a/../../letter.doc", b"Dear"), "^letter.doc: unknown format"),
    (lambda project: project.set_settings("View", {"surface": tube(3, 1)}), "settings of page View"),
    (lambda project: project.rename(" "), "name"),
]
"""Changes of a project, and what their refusals say."""


def test_a_refused_change_leaves_the_project_as_it_was(tmp_path):
    project = relaxed_project(tmp_path / "one")
    other = relaxed_project(tmp_path / "other")
    other.rename("one")
    for change, message in REFUSED:
        with pytest.raises(StitchMeshError, match=message):
            change(project)
        assert same_project(project, other)
    project.close()
    other.close()


def test_an_empty_project_has_nothing_to_undo(tmp_path):
    project = Project.create(tmp_path)
    for step in ("undo", "redo", "undo_label", "redo_label", "restore"):
        with pytest.raises(ParameterError, match=step.removesuffix("_label")):
            getattr(project, step)()
    with pytest.raises(ParameterError, match="import a polygon mesh first"):
        project.apply_label_step(LABEL_ALL)
    with pytest.raises(ParameterError, match="label all its faces first"):
        project.divide(COARSE)
    with pytest.raises(ParameterError, match="divide the labeled mesh first"):
        project.apply_edit(PURL)
    project.close()


def test_a_project_starts_from_each_kind_of_mesh(tmp_path):
    mesh = tube(12, 4)
    labeled = label(mesh)
    write_stitches(tmp_path / "labeled.h5", labeled)
    write_stitches(tmp_path / "stitches.h5", tessellate(labeled, stitch_width=1.0))
    write_labeling(tmp_path / "partly.h5", start_labeling(mesh).label_rows(2))
    write_yarns(tmp_path / "yarns.h5", YARNS)
    project = Project.create(tmp_path / "project")
    read = {name: (tmp_path / f"{name}.h5").read_bytes() for name in ("labeled", "stitches", "partly", "yarns")}
    project.import_mesh("labeled.h5", read["labeled"])
    assert same(project.labeled, labeled)
    project.import_mesh("partly.h5", read["partly"])
    assert project.labeling.row_count == 2 and project.labeled is None
    project.import_mesh("stitches.h5", read["stitches"])
    assert project.mesh is None and project.fabric.face_count > labeled.face_count
    project.apply_edit(PURL)
    with pytest.raises(ParameterError, match="page View"):
        project.import_mesh("yarns.h5", read["yarns"])
    project.close()
    again = Project.open(tmp_path / "project")
    assert same(again.fabric, project.fabric)
    again.close()


def test_a_division_goes_through_a_table():
    division = Division(stitch_width=0.9, stitch_height=0.7, counts={(4, 7): 12, (3, 1): 5}, marked=((5, 9),))
    assert division_of(json.loads(json.dumps(division_table(division)))) == division


def test_a_folder_is_refused_by_name(tmp_path):
    with pytest.raises(FileError, match="holds no project"):
        Project.open(tmp_path)
    project = Project.create(tmp_path, "Hat")
    with pytest.raises(FileError, match="holds a project already"):
        Project.create(tmp_path)
    with pytest.raises(FileError, match="open in another stitchmesh app"):
        Project.open(tmp_path)
    project.close()
    again = Project.open_or_create(tmp_path)
    assert again.name == "Hat"
    again.close()
