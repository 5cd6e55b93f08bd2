# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Hostile numbers, texts and paths cost one line and status 2, or the command does its work; nothing else happens."""

from __future__ import annotations

import os
import random
import re
import shutil
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import pytest

from tests.cli.every_command import WORDS
from tests.cli.hostile import (
    NUMBERS,
    TEXTS,
    Ended,
    Runner,
    cases,
    hostile_paths,
    with_path,
    without_hostile_words,
)
from tests.fuzz import SEED

CASES_OF_A_NIGHT = 150
"""Hostile words of each command in one night; there are 7,000 of all, and another night takes others."""
KEPT_STATES = ("SolverError", "OverloadError")
"""Errors of a state that a simulation has reached; what it has written before is whole and stays."""
ERROR = re.compile(r"(\w+Error|stitchmesh[\w -]*): ")
"""Start of the line of an error; other lines are notes, as on the accuracy of a format."""
HUGE, TINY = "1000000000", "1e-300"


@pytest.fixture(scope="module")
def runner() -> Iterator[Runner]:
    started = Runner()
    yield started
    started.close()


def run_in_copy(runner: Runner, inputs: Path, folder: Path, words: list[str], **limits) -> tuple[Ended, list[str]]:
    """Run a command in a copy of the inputs; returns how it ended, and the names of new files that it left."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(inputs, folder, symlinks=True)
    before = {path.relative_to(folder) for path in folder.rglob("*")}
    ended = runner.run(words, folder, **limits)
    left = {path.relative_to(folder) for path in folder.rglob("*")} - before
    return ended, sorted(map(str, left))


def fault_of(ended: Ended, left: list[str]) -> str:
    """Return what is wrong about the end of a command; no text if nothing is."""
    if "Traceback" in ended.errors or ".stitchmesh-parts" in "".join(left):
        return f"status {ended.status}, left {left}: {ended.errors[-500:]}"
    if ended.status in (0, 1, 3):  # done, not converged, or out of time
        return ""
    lines = ended.errors.splitlines()
    errors = [line for line in lines if ERROR.match(line)]
    kept = {Path(name).name for name in left} <= {"out", "stitches.h5"} or (errors[:1] == lines[-1:] and any(
        line.startswith(KEPT_STATES) for line in errors
    ))
    if ended.status != 2 or errors != lines[-1:] or any("Warning" in line for line in lines) or not kept:
        return f"status {ended.status}, signal {ended.signal}, left {left}: {ended.errors[-500:]}"
    return ""


SWATCH = ["swatch", "stockinette", "-o", "out", "--no-picture", "--quality", "draft", "--device", "cpu"]
PLAIN = ["swatch", "plain", *SWATCH[2:]]
REFUSED = [
    ([*SWATCH, "--columns", HUGE], "memory: a cell of 1000000000 x 1 repeats with"),
    ([*SWATCH, "--tile", HUGE, "1"], "memory: a piece of 1000000000 x 1 tiles"),
    ([*SWATCH, "--texture", "8192", "8192"], "memory: a texture of 8192 x 8192 pixels"),
    ([*SWATCH, "--explore", HUGE], "memory: explore with 1,000,000,000 states"),
    ([*SWATCH, "--yarn-radius", TINY], "yarn radius: got 1e-300 cm; expected 1e-06 to 1e+06 cm"),
    ([*SWATCH, "--stiffness", "k_contact=3.25e11"], "material: k_contact is 3.25e+11; expected a number from 0 to 3.2"),
    ([*SWATCH, "--columns", "1" + "0" * 400], "expected a whole number (at most 1e+15)"),
    ([*SWATCH, "--gamma", "nan"], "--gamma: got 'nan'; expected a number (finite)"),
    (["stretch", "stockinette", "-o", "out", "--course", "0:4%", "--steps", HUGE], "memory: a stretch test of 1,000,0"),
    (["tessellate", "labeled.h5", "-o", "out.h5", "--count", f"0,1={HUGE}"], "at most 1,000,000 stitches are allowed"),
    (["knit", "tube.obj", "-o", "out", "--stitch-width", "8", "--alpha", TINY], "alpha: got 1e-300; expected a part"),
    (["render", "yarns.h5", "-o", "out.png", "--size", "16384", "16384"], "memory: a picture of 16384 x 16384 pixels"),
    (["batch", "sweep.toml", "-o", "out", "--workers", HUGE], "memory: a sweep with 1,000,000,000 workers"),
    (["relax", "yarns.h5", "-o", "out.h5", "--loop-length", TINY], "loop length: got 1e-300; expected 1e-06 to 1e+06"),
    (["edit", "stitches.h5", "--replay", "deep.jsonl", "-o", "out.h5"], "line 1: is nested too deeply; expected at mo"),
    ([*PLAIN, "--spacing", "1e-6"], "images of the cell: 1.47e+13 copies of the cell may touch it"),
    (["label", "tube.obj", "-o", "out.h5", "--auto", "--multiple", HUGE], "rounds of a multiple of 1000000000 with"),
    (["edit", *WORDS["edit"][0], "--log", "x" * 300], "cannot be looked at (File name too long); choose a"),
    (["app", *WORDS["app"][0], "--host", "1e9"], "host: cannot listen on '1e9' port"),
    (["knit", *WORDS["knit"][0], "--resume", "gone.smc"], "gone.smc: there is no such file; check the path"),
    (["relax", *WORDS["relax"][0], "--resume", ""], ": there is no such file; check the path"),
    (["follow", *WORDS["follow"][0], "--drag", "1e9"], "got a drag of 1000000000.0; expected a number from 0"),
    (["render", "cell.h5", "-o", "out.png", "--tile", "1", "0"], "tiles: got 0 rows; expected a whole number from 1"),
    (["label", "pinched.obj", "-o", "out.h5", "--auto", "--stitch-width", "1.5", "--up", "x"], "cm: the mesh is pinch"),
]
"""Commands that ended with a traceback, or took the memory of the machine, and their messages."""


@pytest.mark.parametrize(("words", "message"), REFUSED, ids=lambda value: " ".join(value)[:60])
def test_what_cannot_be_done_is_refused_in_one_line(runner, inputs, tmp_path, words, message):
    ended, left = run_in_copy(runner, inputs, tmp_path / "here", words)
    assert ended.status == 2 and message in ended.errors, ended
    assert fault_of(ended, left) == ""


@pytest.mark.nightly
@pytest.mark.parametrize("name", WORDS)
def test_every_option_takes_or_refuses_numbers_and_texts(runner, inputs, tmp_path, name):
    every = list(cases(name, NUMBERS, texts=TEXTS))
    night = random.Random(f"{SEED} {name}").sample(every, min(len(every), CASES_OF_A_NIGHT))
    for words in without_hostile_words(name):
        ended, _ = run_in_copy(runner, inputs, tmp_path / "here", words)
        assert ended.status == 0, "the command does its work without a hostile word"
    found = {}
    for words in night:
        if fault := fault_of(*run_in_copy(runner, inputs, tmp_path / "here", words)):
            found[" ".join(words)[:300]] = fault
    assert not found, "\n".join(f"{words!r}: {fault}" for words, fault in found.items())


WITHOUT_OUTPUT = ("info", "check", "patterns", "view", "status")
"""Commands that write nothing, or nothing that is asked for."""


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can mount a folder")
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name == "convert" else pytest.mark.nightly) for name in WORDS]
)
def test_a_file_system_that_is_read_only_is_refused_in_one_line(runner, inputs, tmp_path, name):
    here = shutil.copytree(inputs, tmp_path / "here")
    for words in WORDS[name]:
        ended = runner.run([name, *words], here, read_only=True)
        if name in WITHOUT_OUTPUT or (name, words) == ("examples", []):  # a list of the examples
            assert ended.status == 0, ended
        else:
            assert ended.status == 2 and "Read-only file system" in ended.errors and not fault_of(ended, []), ended


def test_a_path_that_the_system_refuses_is_refused_in_one_line(runner, inputs, tmp_path):
    check_paths(runner, inputs, tmp_path, "convert", every=4)


@pytest.mark.nightly
@pytest.mark.parametrize("name", WORDS)
def test_every_command_refuses_every_path_that_the_system_refuses(runner, inputs, tmp_path, name):
    check_paths(runner, inputs, tmp_path, name)


def check_paths(runner: Runner, inputs: Path, tmp_path: Path, name: str, *, every: int = 1) -> None:
    """Run a command with all hostile paths, or with every n-th of them, in the place of each of its paths."""
    traps = shutil.copytree(inputs, tmp_path / "traps")
    (traps / "closed").mkdir()
    (traps / "read-only").mkdir()
    for suffix in ("", ".obj", ".h5", ".toml", ".txt", ".knit", ".png", ".bcc"):
        (traps / f"circle{suffix}").symlink_to(f"circle{suffix}")
    found = {}
    for words in islice(with_path(name, hostile_paths), 0, None, every):
        here = tmp_path / "here"
        shutil.copytree(traps, here, symlinks=True)
        for path, mode in (("closed", 0), ("read-only", 0o500), ("tube.obj", 0), ("yarns.h5", 0)):
            os.chmod(here / path, mode)
        before = set(os.listdir(here))
        ended = runner.run(words, here, unprivileged=True)
        left = sorted(set(os.listdir(here)) - before)
        for path in ("closed", "read-only"):
            os.chmod(here / path, 0o700)
        shutil.rmtree(here)
        if fault := fault_of(ended, left):
            found[" ".join(words)[:200]] = fault
    assert not found, "\n".join(f"{words!r}: {fault}" for words, fault in found.items())
