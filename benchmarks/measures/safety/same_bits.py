# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Check that a change of the code leaves the bits of every result unchanged.

    python benchmarks/run.py same-bits make out/before --glove glove.bcc     # at the commit before the change
    python benchmarks/run.py same-bits make out/after --glove glove.bcc      # at the commit after it
    python benchmarks/run.py same-bits compare out/before out/after          # prints the arrays that differ

`make` runs whole commands on the CPU: the sweater of `make knit`; a hat with rope cables, knitted in a spiral; two
meshes whose rows are found; six swatches, of which two have a relaxed cell and one is woven; eight swatches in one
call; a glove that is relaxed in two parts with a checkpoint between them; a hat that is edited and relaxed again;
and three scenes of cloth and yarns. `compare` compares every array of every HDF5 file that the commands wrote. The
linear algebra runs on one thread and with one set of instructions, so that the processor cannot change the results
between the two runs.
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np

from benchmarks.table import Rows

ROOT = Path(__file__).resolve().parents[3]
HAT = "assets/meshes/hat.obj"
SWATCHES = {
    "stockinette": ["stockinette", "--relax-cell"],
    "rib2x2": ["rib2x2", "--relax-cell"],
    "garter": ["garter"],
    "feather-and-fan": ["feather-and-fan"],
    "honeycomb": ["slip-stitch-honeycomb"],
    "twill-3x2": ["twill-3x2"],
}
"""Arguments of the swatch commands by name; all run at draft quality."""
FOUND_ROWS = ("alien", "sock")
"""Meshes of which no row is labeled before."""
SCENES = ("corner", "puckering", "sheared")
"""Scenes of `examples/mixed`: a corner that is pulled and let go, a seam that puckers, and a patch that is sheared."""
BATCH = """
import sys
from pathlib import Path
import stitchmesh as sm

names = "stockinette garter rib1x1 rib2x2 seed twisted-rib lice plain".split()
requests = [sm.SwatchRequest(name, quality="draft", relax_cell=name != "plain") for name in names]
for name, swatch in zip(names, sm.relax_swatches(requests, device="cpu", progress=False), strict=True):
    sm.write_yarns(Path(sys.argv[1]) / f"batch-{name}.h5", swatch.yarns)
"""
"""A program that makes eight swatches in one call: seven knits whose cells relax, and a weave."""
EDIT = {"edit": "change_stitch", "arguments": {"faces": [700, 702, 704], "stitch": "p"}}
"""The edit of the README."""


def stitchmesh(*words: str) -> None:
    """Run one command of StitchMesh."""
    python("-m", "stitchmesh", *words)


def python(*words: str) -> None:
    """Run Python on the CPU with one thread and one set of instructions."""
    environment = {
        **os.environ,
        "OPENBLAS_NUM_THREADS": "1",
        "OPENBLAS_CORETYPE": "Haswell",
        "PYTHONPATH": str(ROOT),
    }
    done = subprocess.run(
        [sys.executable, *words], check=False, cwd=ROOT, env=environment, capture_output=True, text=True
    )
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(words)}: {done.stderr}")


def make(folder: Path, /, *, glove: Path) -> Rows:
    """Run all commands, and write their files to a folder.

    Args:
        folder: the folder.
        glove: yarns of a glove, glove.bcc.
    """
    folder = folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    draft = ["--quality", "draft", "--device", "cpu"]
    sweater = ["knit", "assets/meshes/sweater.obj", "--stitch-width", "1.5", "--no-picture"]
    stitchmesh(*sweater, *draft, "-o", f"{folder}/sweater")
    ropes = ["knit", HAT, "--pattern", "rope-cable", "--spiral", "--stitch-width", "1.2", "--no-picture"]
    stitchmesh(*ropes, *draft, "-o", f"{folder}/ropes")
    for name in FOUND_ROWS:
        found = ["knit", f"assets/meshes/{name}.obj", "--auto", "--stitch-width", "2", "--no-picture"]
        stitchmesh(*found, *draft, "-o", f"{folder}/auto-{name}")
    for name, words in SWATCHES.items():
        stitchmesh("swatch", *words, *draft, "-o", f"{folder}/{name}")
    python("-c", BATCH, str(folder))
    for name in SCENES:
        scene = ["drape", f"examples/mixed/{name}.toml", "--no-picture", "--device", "cpu"]
        stitchmesh(*scene, "-o", f"{folder}/{name}")
    relax_glove_in_two_parts(folder, glove, draft)
    edit_and_relax_again(folder, draft)
    yield f"{sum(1 for _array in arrays(folder))} arrays in {folder}"


def relax_glove_in_two_parts(folder: Path, glove: Path, draft: list[str]) -> None:
    """Relax for 60 iterations, and continue from the checkpoint for 60 iterations."""
    words = ["relax", str(glove.resolve()), *draft, "--checkpoint-every", "60", "-o", f"{folder}/glove.h5"]
    stitchmesh(*words, "--max-iterations", "60")
    stitchmesh(*words, "--max-iterations", "120", "--resume", f"{folder}/glove.checkpoints/checkpoint.smc")


def edit_and_relax_again(folder: Path, draft: list[str]) -> None:
    """Knit a hat, change three of its stitches to purl, and relax it again."""
    log, hat = folder / "log.jsonl", folder / "hat"
    log.write_text(json.dumps(EDIT) + "\n")
    stitchmesh("knit", HAT, "--stitch-width", "0.8", "--no-picture", *draft, "-o", str(hat))
    stitchmesh("edit", f"{hat}/stitches.h5", "--replay", str(log), "-o", f"{folder}/edited.h5")
    fabrics = ["--before", f"{hat}/stitches.h5", "--after", f"{folder}/edited.h5"]
    stitchmesh("relax-edited", f"{hat}/yarns.h5", *fabrics, *draft, "-o", f"{folder}/again.h5")


def arrays(folder: Path) -> Iterator[tuple[str, np.ndarray]]:
    """Return every array of every HDF5 file of a folder by file and name."""
    for path in sorted(folder.rglob("*.h5")):
        with h5py.File(path) as file:
            names: list[str] = []
            file.visit(names.append)
            for name in sorted(names):
                if isinstance(file[name], h5py.Dataset):
                    yield f"{path.relative_to(folder)}:{name}", np.asarray(file[name][()])


def compare(before: Path, after: Path, /) -> Rows:
    """Name every array that differs; the exit status is then 1."""
    one, two = dict(arrays(before)), dict(arrays(after))
    differing = 0
    for name in sorted(one.keys() | two.keys()):
        difference = differs(one.get(name), two.get(name))
        if difference:
            differing += 1
            yield f"{name}: {difference}"
    yield f"{len(one)} arrays, {differing} differ; {digest(two)}"
    return int(differing > 0)


def differs(one: np.ndarray | None, two: np.ndarray | None) -> str:
    """Return a description of the differences between two arrays; an empty text if they are equal."""
    if one is None or two is None:
        return "in one folder only"
    if one.shape != two.shape or one.dtype != two.dtype:
        return f"{one.dtype} {one.shape} before, {two.dtype} {two.shape} after"
    if one.tobytes() == two.tobytes() or (one.dtype.hasobject and np.array_equal(one, two)):
        return ""
    if not np.issubdtype(one.dtype, np.number):
        return "different values"
    return f"largest difference {np.abs(one.astype(float) - two.astype(float)).max():.3g}"


def digest(found: dict[str, np.ndarray]) -> str:
    """Return one hash of all arrays."""
    state = hashlib.sha256()
    for name, value in sorted(found.items()):
        state.update(name.encode() + (repr(value.tolist()).encode() if value.dtype.hasobject else value.tobytes()))
    return state.hexdigest()[:16]


ACTIONS = (make, compare)
