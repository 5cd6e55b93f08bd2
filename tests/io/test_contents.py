# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Only regular files up to a stated size are read, and all of them in one place."""

from __future__ import annotations

import ast
import os
import re
import socket
from pathlib import Path

import pytest

from stitchmesh.cli import main as cli
from stitchmesh.editing.history import read_log
from stitchmesh.errors import FileError
from stitchmesh.io import contents
from stitchmesh.io.any_file import read_any
from stitchmesh.io.contents import read_bytes
from stitchmesh.io.folder_lock import NAME, is_locked
from stitchmesh.io.meshes import FORMATS as MESH_FORMATS
from stitchmesh.io.toml_file import read_table
from stitchmesh.io.yarns import FORMATS as YARN_FORMATS
from stitchmesh.jobs.job_status import read_status
from stitchmesh.jobs.sweep.result_table import read_table as read_result_table
from tests.gallery import ROOT

OPENING = re.compile(
    r"open|os\.open|.*\.(open|read_text|read_bytes|fromfile|loadtxt|FindOrOpen)|np\.load|h5py\.File|Usd\.Stage\.Open|"
    r"meshio\.read|trimesh\.load.*|parquet\.(read_table|ParquetFile)"
)
"""Functions that open files."""
MAY_OPEN = re.compile(
    r"(open|read_text|read_bytes|fromfile|loadtxt|FindOrOpen|np\.load|h5py\.File|Stage\.Open|meshio\.read)\(|trimesh\.load|"
    r"parquet\."
)
"""What stands in the text of a file that may call one of them."""
ELSEWHERE = {
    # Files and folders of the system and of the program itself.
    "app/browser/bridge.py", "budget/calibration.py", "budget/tables.py", "cli/budget_options.py", "cli/main.py",
    "compute/device.py", "compute/free_memory.py", "compute/threads.py", "first_use.py",
    "jobs/book/swatch_book.py", "jobs/sweep/report_page.py", "mixed/scene/scene.py", "render/plots/plot_file.py",
    "yarngen/templates/table.py",
    # What this process writes.
    "app/guard.py", "app/pages/swatch/exports.py", "app/pages/downloads.py", "io/atomic.py",
    "io/checkpoint_file.py", "io/own_files.py", "jobs/sweep/result_table.py", "render/animation_pictures.py",
    "render/swatch_picture.py",
    # Contents that have been read, and copies or stages that a child process reads.
    "patterns/charts/other_images.py", "render/pattern_sheet.py",
    "io/guarded_child.py", "io/hdf5.py", "io/mesh_formats/by_meshio.py", "io/usd_stage.py",
    "jobs/sweep/parquet_columns.py",
    "patterns/charts/chart_image.py",
}  # fmt: skip
"""Modules that open files which no user names."""
NO_FILES = {"Project.open", "cls.open", "webbrowser.open"}
"""Functions of the same names that open no file themselves."""


def traps(folder: Path) -> dict[Path, str]:
    """Return places that are no files, with what a message calls them."""
    os.mkfifo(folder / "pipe")
    (folder / "folder").mkdir()
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind(str(folder / "socket"))
    return {folder / "pipe": "is a pipe", folder / "folder": "is a folder", folder / "socket": "is a socket",
            Path("/dev/zero"): "is a device", Path("/proc/self/mem"): "is empty"}  # fmt: skip


def test_what_is_no_file_is_refused_at_once(tmp_path):
    for place, words in traps(tmp_path).items():
        with pytest.raises(FileError, match=words) as caught:
            read_bytes(place)
        assert str(caught.value).startswith(f"{place}: ") and "\n" not in str(caught.value)


@pytest.mark.parametrize("suffix", sorted({*MESH_FORMATS, *YARN_FORMATS, ".smobj", ".st"}))
def test_every_format_refuses_a_pipe(tmp_path, suffix):
    os.mkfifo(tmp_path / f"file{suffix}")
    with pytest.raises(FileError, match="is a pipe"):
        read_any(tmp_path / f"file{suffix}")


@pytest.mark.parametrize(
    ("name", "read"),
    [
        ("edits.jsonl", read_log),
        ("job.toml", read_table),
        ("status.json", lambda path: read_status(path.parent)),
        ("rows.parquet", lambda path: read_result_table(path.parent)),
    ],
)
def test_what_the_program_keeps_is_read_from_files_only(tmp_path, name, read):
    os.mkfifo(tmp_path / name)
    with pytest.raises(FileError, match=r"is a pipe|holds no"):
        read(tmp_path / name)


def test_a_pipe_in_the_place_of_a_lock_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / NAME)
    assert not is_locked(tmp_path)


def test_a_file_is_read_up_to_a_stated_size(tmp_path, monkeypatch):
    (tmp_path / "large").write_bytes(b"12345")
    monkeypatch.setattr(contents, "LARGEST_FILE", 4)
    with pytest.raises(FileError, match="has 5 bytes; expected 4 at most"):
        read_bytes(tmp_path / "large")
    monkeypatch.setattr(contents, "LARGEST_FILE", 5)
    assert read_bytes(tmp_path / "large") == b"12345"


def test_a_link_to_a_file_is_read_and_a_link_to_a_device_is_refused(tmp_path, capsys):
    (tmp_path / "file").write_bytes(b"1")
    (tmp_path / "link").symlink_to(tmp_path / "file")
    assert read_bytes(tmp_path / "link") == b"1"
    (tmp_path / "mesh.obj").symlink_to("/dev/zero")
    assert cli.main(["info", str(tmp_path / "mesh.obj")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"FileError: {tmp_path / 'mesh.obj'}: is a device")


def test_files_that_users_name_are_opened_in_one_place():
    package, opening = ROOT / "stitchmesh", set()
    for path in package.rglob("*.py"):
        text = path.read_text()
        if not MAY_OPEN.search(text):  # to parse all files takes seconds
            continue
        calls = [ast.unparse(node.func) for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call)]
        if any(OPENING.fullmatch(call) and call not in NO_FILES for call in calls):
            opening.add(path.relative_to(package).as_posix())
    assert opening == {"io/contents.py", *ELSEWHERE}
