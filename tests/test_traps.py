# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Nothing that lies in the present folder is executed, or read as settings: data of others may lie there."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import pytest

from stitchmesh.io.yarns import write_yarns
from tests.app.project.projects import YARNS
from tests.gallery import ROOT

MODULES = ("sitecustomize", "usercustomize", "numpy", "multiprocessing", "json", "warp", "h5py", "matplotlib", "runpy")
PACKAGES = ("vtkmodules", "pxr", "distributed", "pyvista", "dask", "stitchmesh")
SWEEP = 'picture = false\n[job]\nquality = "draft"\ndevice = "cpu"\n[job.swatch]\npattern = "stockinette"\n'
PROGRAM = "import sys\nfrom stitchmesh.cli.main import main\nif __name__ == '__main__':\n    sys.exit(main())\n"
"""The same as the program that an installation makes, which puts its own folder in front of the path."""


@pytest.fixture
def folder(tmp_path):
    """A folder with data among traps, each of which leaves a file when it is executed."""
    made = tmp_path / "data"
    made.mkdir()
    for name in (*(f"{name}.py" for name in MODULES), *(f"{name}/__init__.py" for name in PACKAGES)):
        path = made / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(f"open({str(tmp_path / 'sprung')!r}, 'a').write({name + ' '!r})\nraise SystemExit('trap')\n")
    (made / "matplotlibrc").write_bytes(b"text.usetex: True\n\xff\n")
    (made / ".env").write_text("VTK_DEFAULT_OPENGL_WINDOW=none\n")
    write_yarns(made / "yarns.h5", YARNS)
    write_yarns(made / "stage.usda", YARNS)
    (made / "sweep.toml").write_text(SWEEP)
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "program.py").write_text(PROGRAM)
    return made


@pytest.mark.parametrize("words", [
    "convert stage.usda out.bcc",
    "render yarns.h5 -o out.png --size 64 64",
    "swatch stockinette --quality draft --device cpu -o out",
    "batch sweep.toml -o out --workers 1",
])  # fmt: skip
def test_no_code_of_the_present_folder_runs(folder, words):
    before = sorted(path.name for path in folder.iterdir())
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    program = [sys.executable, str(folder.parent / "bin" / "program.py"), *words.split()]
    done = subprocess.run(program, cwd=folder, env=environment, capture_output=True, text=True)
    sprung = folder.parent / "sprung"
    assert not sprung.exists(), sprung.read_text()
    assert done.returncode == 0, done.stderr
    for path in ("out.bcc", "out.png", "out"):
        shutil.rmtree(folder / path) if (folder / path).is_dir() else (folder / path).unlink(missing_ok=True)
    assert sorted(path.name for path in folder.iterdir()) == before
