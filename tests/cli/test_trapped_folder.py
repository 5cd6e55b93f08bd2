# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Every command in a folder full of traps: links, a pipe, hostile modules and names, and files of the user's.

The folder is compared before and after: a command changes nothing that was there, follows no link out of its output,
executes nothing of the folder, waits for no pipe, and shows no traceback.
"""

from __future__ import annotations

import os
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from stitchmesh.cli.main import COMMANDS
from stitchmesh.io.folder_lock import NAME as LOCK
from stitchmesh.io.own_files import RECORD
from stitchmesh.io.part_folder import PARTS
from tests.cli.every_command import WORDS
from tests.cli.hostile import options_of, quick_words
from tests.nightly import at_night, mostly_at_night

MODULES = ("sitecustomize", "usercustomize", "numpy", "multiprocessing", "json", "warp", "h5py", "matplotlib", "runpy")
PACKAGES = ("vtkmodules", "pxr", "distributed", "pyvista", "dask", "stitchmesh")
"""What a command or a child of it would import from the present folder, if it looked there."""
OWN = {"convert": ["yarns.usda", "out.bcc"], "batch": ["sweep.toml", "--workers", "1", "-o", "out"]}
"""Other words than those of ``WORDS``: their children read USD, and do the jobs of a sweep."""
SERVERS = {"view", "app"}
"""Commands that serve the application until they are interrupted."""
NAMES = sorted(WORDS.keys() - SERVERS)
FEW = ("convert", "run")
"""Commands that every run of the tests tries: one writes a file, and its child reads USD; the other writes a folder in
which stages are removed again."""


@pytest.fixture
def trapped(inputs, tmp_path) -> Path:
    """Return a folder with the inputs and with traps, and a folder beside it to which the links lead."""
    folder, victim = tmp_path / "trapped", tmp_path / "victim"
    for path in sorted(inputs.rglob("*")):
        target = folder / path.relative_to(inputs)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.mkdir() if path.is_dir() else target.write_bytes(path.read_bytes())
    for name in ("part-abcdefgh", "label-0123456789abcdef", "0001"):
        (victim / name).mkdir(parents=True)
        (victim / name / ".lock").write_text("")
        (victim / name / "mine.txt").write_text("mine")
    (victim / "0007.smc").write_text("mine")
    (folder / "out" / "stages" / "my_data").mkdir(parents=True)
    (folder / "out" / "stages" / "my_data" / "a.txt").write_text("mine")
    for name in (*(f"{name}.py" for name in MODULES), *(f"{name}/__init__.py" for name in PACKAGES)):
        (folder / name).parent.mkdir(exist_ok=True)
        sprung = f"open({str(tmp_path / 'executed')!r}, 'a').write({name + ' '!r})"
        (folder / name).write_text(f"{sprung}\nraise SystemExit('trap')\n")
    (folder / "matplotlibrc").write_bytes(b"text.usetex: True\n\xff\n")
    (folder / ".env").write_text("VTK_DEFAULT_OPENGL_WINDOW=none\n")
    for suffix in ("obj", "toml", "h5"):
        os.mkfifo(folder / f"pipe.{suffix}")
    for name in (b"line\nend.txt", b"\x1b[31mred.txt", b"<script>alert(1)<_script>", b"\xff\xfe.txt"):
        (folder / os.fsdecode(name)).write_text("mine")
    (folder / "secret.txt").write_text("mine")
    (folder / "secret.txt").chmod(0o600)
    return folder


def contents(folder: Path) -> dict[str, tuple[int, object]]:
    """Return the mode and the bytes of every file below a folder, and where links lead."""
    found: dict[str, tuple[int, object]] = {}
    for path in sorted(folder.rglob("*")):
        mode = path.lstat().st_mode
        held = os.readlink(path) if stat.S_ISLNK(mode) else path.read_bytes() if stat.S_ISREG(mode) else None
        found[str(path.relative_to(folder))] = mode, held
    return found


def run(folder: Path, words: list[str]) -> subprocess.CompletedProcess[bytes]:
    """Run the program as a user does, in the folder."""
    program = Path(sys.executable).with_name("stitchmesh")
    command = [str(program), *words]
    return subprocess.run(command, cwd=folder, capture_output=True, stdin=subprocess.DEVNULL, check=False)


def check(folder: Path, words: list[str], *, statuses: tuple[int, ...]) -> None:
    """Run a command; all that was there is as before, and neither a trap nor a traceback was sprung."""
    before, behind = contents(folder), contents(folder.parent / "victim")
    done = run(folder, words)
    assert not (folder.parent / "executed").exists(), (folder.parent / "executed").read_text()
    assert b"Traceback" not in done.stderr and done.returncode in statuses, done.stderr.decode(errors="replace")
    after = contents(folder)
    assert {name: after.get(name) for name in before} == before
    assert contents(folder.parent / "victim") == behind


def words_of(name: str) -> list[str]:
    """Return the words with which a command does its work quickly."""
    return [name, *OWN.get(name, WORDS[name][0]), *quick_words(list(options_of(COMMANDS[name])), "")]


def test_every_command_is_tried():
    assert COMMANDS.keys() == WORDS.keys()


@pytest.mark.parametrize("name", mostly_at_night(NAMES, by_day=FEW))
def test_a_command_changes_nothing_of_the_users_and_replaces_no_output_that_they_changed(trapped, name):
    before = contents(trapped)
    check(trapped, words_of(name), statuses=(0,))
    made = {path for path in set(contents(trapped)) - set(before) if (trapped / path).is_file()}
    written = {path for path in made if Path(path).name not in (RECORD, LOCK) and "stages" not in Path(path).parts}
    assert bool(written) == (name not in ("info", "check", "patterns", "examples", "status", "warm-up"))
    for path in written:
        (trapped / path).write_text("changed by the user")
    if written:
        check(trapped, words_of(name), statuses=(2,))


@pytest.mark.parametrize("name", mostly_at_night(NAMES, by_day=["run"]))
def test_links_in_the_output_folder_are_not_followed(trapped, name):
    for link in (PARTS, "frames", "tasks", "jobs", RECORD, LOCK, "report.json", "out.h5"):
        (trapped / "out" / link).symlink_to(trapped.parent / "victim")
    shutil.rmtree(trapped / "out" / "stages")
    (trapped / "out" / "stages").symlink_to(trapped.parent / "victim")
    words = [f"out/{word}" if word.startswith("out.") else word for word in words_of(name)]
    writes = any(word.startswith("out") for word in words[1:])
    check(trapped, words, statuses=(2,) if writes else (0,))


@pytest.mark.parametrize("words", [["info", "pipe.h5"], *at_night(["run", "pipe.toml"])])
def test_a_pipe_in_the_place_of_an_input_is_refused(trapped, words):
    check(trapped, words, statuses=(2,))
