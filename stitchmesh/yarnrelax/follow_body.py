# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Simulates yarns that follow a moving body in time: the order of operations."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from os import fspath
from typing import Any, TypedDict

from stitchmesh import __version__
from stitchmesh.compute.device import alone, device_named
from stitchmesh.errors import ParameterError, check_kind
from stitchmesh.io.checkpoint_file import (
    CheckpointFile,
    checked_header,
    read_checkpoint,
    was_written,
    write_checkpoint,
)
from stitchmesh.io.contents import FilePath
from stitchmesh.linking.certificate import refuse_pull_through
from stitchmesh.progress import shown_stages
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.run import SHOWN, Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.body_follower import BodyFollower, FollowInputs, FollowState
from stitchmesh.yarnrelax.energies.term import YarnChoice
from stitchmesh.yarnrelax.fingerprint import fingerprint, refuse_other_inputs, yarn_fingerprint
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.motion.follow_defaults import DRAG, MOST_DRAG
from stitchmesh.yarnrelax.motion.moving_body import MovingBody
from stitchmesh.yarnrelax.motion.self_cuts import refuse_self_cuts

logger = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class YarnFrame:
    """The yarns at one frame of the body."""

    number: int
    """Number of the frame, from 0."""
    time: float
    """Time [s]."""
    yarns: YarnSet
    """The yarns."""
    report: dict[str, Any]
    """Figures of the frame as plain numbers."""


class _Header(TypedDict):
    """The header of a checkpoint."""

    inputs: dict[str, str]
    frame: int
    steps: int
    margin: float
    lists_age: int


def follow_body(
    yarns: YarnSet,
    body: MovingBody,
    *,
    material: YarnMaterial | None = None,
    quality: str | Quality = DEFAULT_QUALITY,
    device: str | None = None,
    terms: Sequence[YarnChoice] = (),
    drag: float = DRAG,
    run: Run[YarnSet] = SHOWN,
) -> Iterator[YarnFrame]:
    """Simulate yarns that follow a moving body, and yield them at each frame of the body.

    The yarns begin at rest, and move by the solver ``dynamics``. All arguments are checked before the first frame.

    Args:
        yarns: the yarns at the first frame, outside the body, for example relaxed around it.
        body: the body, its friction and the control points that it carries.
        material: stiffnesses; None for the material ``stitchmesh``, scaled to the radius of the yarns. ``drag``
            replaces its global damping.
        quality: a preset or a ``Quality``; its solver is not used.
        device: "cpu", "cuda:0" ...; None for the first GPU, or the CPU if there is no GPU.
        terms: further energies, such as gravity.
        drag: rate at which the air slows motion down [1 / s].
        run: progress, checkpoints, whose interval is counted in frames, and the checkpoint to resume. If that file does
            not exist yet, the run begins at the first frame. The frames of a resumed run have the bits of a run that
            never stopped.

    Yields:
        The yarns at each frame; a resumed run yields only the frames after its checkpoint.

    Raises:
        ParameterError: a choice does not fit, the body cuts through itself in a frame, or the checkpoint belongs to a
            run with other inputs.
        FileError: a checkpoint cannot be written or read.
        SolverError: yarns are too close to each other or too deep in the body; the message names the frame.
    """
    if not 0.0 <= drag <= MOST_DRAG:
        raise ParameterError(f"follow_body: got a drag of {drag}; expected a number from 0 to {MOST_DRAG:g} [1/s]")
    run.refuse_all_but("follow_body", "checkpoints", "resume")
    own = _with_drag(yarns, material, drag), replace(quality_named(quality), solver="dynamics")
    inputs = FollowInputs(yarns, body, *own, tuple(terms), device_named(device))
    with alone():
        refuse_self_cuts(body.moving, inputs.device)
        follower = BodyFollower(inputs)
        written = _fingerprints(inputs) if run.checkpoints is not None or run.resume is not None else {}
        resumed = run.resume is not None and was_written(run.resume)
        if run.resume is not None and resumed:
            _resume(follower, run.resume, written)
        elif run.resume is not None:
            logger.info("%s: is not there yet; the run begins at the first frame", run.resume)
    return _frames(follower, run, written, resumed=resumed)


def _with_drag(yarns: YarnSet, material: YarnMaterial | None, drag: float) -> YarnMaterial:
    """Return the material with the global damping that slows a uniform motion down at the rate of the drag."""
    check_kind("follow_body", yarns, YarnSet)
    chosen = material or YarnMaterial.named().of_radius(float(yarns.radius.mean()))
    mass = yarns.masses_per_length(chosen.mass_per_length)[yarns.segment_yarn] * yarns.rest_length
    return replace(chosen, k_global=0.5 * drag * float(mass.mean()))


def _frames(
    follower: BodyFollower, run: Run[YarnSet], written: dict[str, str], *, resumed: bool
) -> Iterator[YarnFrame]:  # fmt: skip
    """Yield the frames; write a checkpoint after the caller has dealt with a frame."""
    given, last = follower.inputs.yarns, len(follower.times) - 1
    with shown_stages(run.progress) as report:
        if not resumed:
            yield _frame(follower, 0.0)
        while follower.frame < last:
            began = time.perf_counter()
            with alone():
                follower.advance()
                frame = _frame(follower, time.perf_counter() - began)
            report("follow", follower.frame / last, f"frame {follower.frame} of {last}")
            yield frame
            if run.checkpoints is not None and follower.frame % run.checkpoints.every == 0:
                state = follower.state()
                numbers = {name: value for name, value in vars(state).items() if name != "arrays"}
                write_checkpoint(run.checkpoints.path, CheckpointFile({"inputs": written, **numbers}, state.arrays))
    device = str(follower.inputs.device)
    refuse_pull_through(given, follower.yarns(), device)


def _frame(follower: BodyFollower, seconds: float) -> YarnFrame:
    report = {**follower.report(), "seconds": seconds}
    return YarnFrame(follower.frame, report["time"], follower.yarns(), report)


def _resume(follower: BodyFollower, path: FilePath, written: dict[str, str]) -> None:
    content = read_checkpoint(path)
    header = checked_header(path, content, _Header)
    refuse_other_inputs(fspath(path), header["inputs"], written)
    follower.resume(FollowState(
        header["frame"], header["steps"], header["margin"], header["lists_age"], content.arrays
    ))  # fmt: skip


def _fingerprints(inputs: FollowInputs) -> dict[str, str]:
    """Return everything that decides a run, as short strings."""
    found = {"stitchmesh": __version__, "device": "cuda" if inputs.device.is_cuda else "cpu"}
    found |= yarn_fingerprint(inputs.yarns)
    found |= fingerprint("material", inputs.material)
    found |= fingerprint("quality", inputs.quality, without=("tolerance", "largest_change", "max_iterations"))
    body = inputs.body
    found |= fingerprint("body", body, without=("carried",))
    found |= {"carried": "none"} if body.carried is None else fingerprint("carried", body.carried)
    for number, term in enumerate(inputs.terms):
        found |= fingerprint(f"term {number} ({type(term).__name__})", term)
    return found
