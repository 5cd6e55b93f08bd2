# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Checkpoints of a run of the mixed system: the state that a resumed run needs to end with the same bits.

A checkpoint is written between two steps in time, or between two iterations of a search for an equilibrium. It holds
the state of the simulation, the sums of the report, the number of frames, and a fingerprint of everything that
decides the run. Output and tolerances of processors do not count: pictures and formats may differ.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from os import fspath
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh import __version__
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.checkpoint_file import CheckpointFile, checked_header, read_checkpoint, write_checkpoint
from stitchmesh.mixed.output.report import RunTotals
from stitchmesh.mixed.scene.scene_fabric import PreparedScene
from stitchmesh.yarnrelax.fingerprint import fingerprint


@dataclass(frozen=True, eq=False)
class RunCheckpoint:
    """A run between two steps, or between two iterations of a search for an equilibrium."""

    totals: RunTotals
    frames: int
    """Number of frames so far."""
    arrays: Mapping[str, NDArray[Any]]
    """The arrays of the simulation."""


class _Header(TypedDict):
    """The header of a checkpoint."""

    inputs: dict[str, str]
    totals: RunTotals
    frames: int


def run_inputs(prepared: PreparedScene, device: wp.Device) -> dict[str, str]:
    """Return everything that decides a run, by name, as short strings."""
    found = {"stitchmesh": __version__, "device": "cuda" if device.is_cuda else "cpu"}
    for number, term in enumerate(prepared.terms):
        found |= {f"term {number}": type(term).__name__} | fingerprint(f"term {number}", term)
    found["cloth.seam_rods"] = str(prepared.fabric.seam_material)
    found |= fingerprint("scene", prepared.scene, without=("output", "cloth", "yarns", "region"))
    # An automatic region is part of the checkpoint: it may depend on a clock, and change while the run goes on.
    section = prepared.scene.region
    # A resumed run compares any other region itself instead of the entries that place it.
    of_place = ("yarns", "nodes", "seconds", "adapt_every", "boxes", "faces", "rings")
    found |= fingerprint("region", section, without=() if section.yarns == "automatic" else of_place)
    if section.yarns != "automatic":
        found |= fingerprint("region", prepared.region)
    found |= fingerprint("cloth", prepared.fabric.cloth) | fingerprint("yarns", prepared.fabric.yarns)
    found |= fingerprint("cloth material", prepared.fabric.cloth_material, without=("name", "source"))
    return found | fingerprint("yarn materials", prepared.fabric.yarn_materials)


def write_run(path: Path, inputs: Mapping[str, str], state: RunCheckpoint) -> None:
    """Write a checkpoint; the checkpoint before it is kept.

    Raises:
        FileError: the file cannot be written.
    """
    header = {"inputs": dict(inputs), "totals": asdict(state.totals), "frames": state.frames}
    arrays = {name: np.asarray(array) for name, array in state.arrays.items()}
    write_checkpoint(path, CheckpointFile(header, arrays))


def read_run(path: Path, inputs: Mapping[str, str]) -> RunCheckpoint:
    """Read a checkpoint.

    Raises:
        FileError: the file is missing, damaged, or not a checkpoint of a run.
        ParameterError: the checkpoint belongs to a run of another scene; the message says what differs.
    """
    content = read_checkpoint(path)
    if "totals" not in content.header:
        raise FileError(f"{fspath(path)}: is a checkpoint of yarns that relax; expected one of stitchmesh drape")
    header = checked_header(path, content, _Header)
    written = header["inputs"]
    differing = [key for key in {**written, **inputs} if written.get(key) != inputs.get(key)]
    if differing:
        key, more = differing[0], f", and {len(differing) - 1} more" if len(differing) > 1 else ""
        found = f"{key} is {inputs.get(key, 'absent')} and was {written.get(key, 'absent')}{more}"
        raise ParameterError(f"{fspath(path)}: is of a run of another scene: {found}; give it the same scene")
    return RunCheckpoint(header["totals"], header["frames"], content.arrays)
