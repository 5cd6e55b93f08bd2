# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What `make setup` installs has a hash in the lock file, and so has the pip that installs it."""

from __future__ import annotations

import re

from tests.gallery import ROOT

LOCK = (ROOT / "requirements.lock").read_text()
MAKEFILE = (ROOT / "Makefile").read_text()


def test_each_package_has_one_version_and_a_hash():
    entries = re.split(r"^(?=[a-z0-9])", LOCK, flags=re.MULTILINE)[1:]
    assert len(entries) > 50
    assert [entry for entry in entries if not re.match(r"\S+==\S+( ; .*)? \\\n    --hash=sha256:", entry)] == []


def test_pip_comes_from_the_lock_file_first_and_the_setuptools_of_the_machine_goes():
    installs = [line.split(" -m pip ")[1] for line in MAKEFILE.splitlines() if " -m pip " in line]
    verified = "install --quiet --require-hashes --only-binary :all: -r "
    assert installs == [
        f"{verified}$(VENV)/pip.lock", "uninstall --quiet --yes setuptools", f"{verified}requirements.lock",
        "install --quiet --no-deps --no-build-isolation --editable .",
    ]  # fmt: skip
    assert re.search(r"^pip==", LOCK, re.MULTILINE) and not re.search(r"^setuptools==", LOCK, re.MULTILINE)
