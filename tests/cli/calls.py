# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Calls of commands in this process, which must succeed or be refused in one line."""

from __future__ import annotations

from pathlib import Path

from stitchmesh.cli.main import main


def run(*words: object) -> None:
    """Run a command that must succeed."""
    assert main([str(word) for word in words]) == 0


def refused(capsys, *words: object) -> str:
    """Run a command that must fail, and return its error message of one line."""
    capsys.readouterr()
    try:
        status = main([str(word) for word in words])
    except SystemExit as stop:  # the words are those of no command
        status = stop.code
    printed = capsys.readouterr()
    assert status == 2 and printed.err.count("\n") == 1
    assert "Traceback" not in printed.err and " at 0x" not in printed.err
    return printed.err


def refused_without_files(capsys, folder: Path, *words: object) -> str:
    """Run a command that must fail and write nothing into a folder, and return its error message of one line."""
    before = sorted(folder.rglob("*"))
    message = refused(capsys, *words)
    assert sorted(folder.rglob("*")) == before
    return message
