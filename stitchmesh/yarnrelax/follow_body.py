# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Simulates yarns that follow a moving body in time: the order of operations."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace

from stitchmesh import __version__
from stitchmesh.compute.device import alone, device_named
from stitchmesh.errors import ParameterError, check_kind
from stitchmesh.io.checkpoint_file import CheckpointFile
from stitchmesh.linking.certificate import refuse_pull_through
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.run import SHOWN, Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.body_follower import BodyFollower, FollowInputs, FollowState
from stitchmesh.yarnrelax.energies.term import YarnChoice
from stitchmesh.yarnrelax.fingerprint import fingerprint, yarn_fingerprint
from stitchmesh.yarnrelax.frame_run import FrameHeader, FrameRun, YarnFrame, checkpoint_of
from stitchmesh.yarnrelax.model.material import YarnMaterial, material_of
from stitchmesh.yarnrelax.motion.follow_defaults import DRAG, MOST_DRAG
from stitchmesh.yarnrelax.motion.moving_body import MovingBody
from stitchmesh.yarnrelax.motion.self_cuts import refuse_self_cuts


class _Header(FrameHeader):
    """The header of a checkpoint."""

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
        resumed = checkpoint_of(run, written, _Header)
        if resumed is not None:
            header, arrays = resumed
            numbers = header["frame"], header["steps"], header["margin"], header["lists_age"]
            follower.resume(FollowState(*numbers, arrays))
    return _frames(follower, run, written, resumed=resumed is not None)


def _with_drag(yarns: YarnSet, material: YarnMaterial | None, drag: float) -> YarnMaterial:
    """Return the material with the global damping that slows a uniform motion down at the rate of the drag."""
    check_kind("follow_body", yarns, YarnSet)
    chosen = material or material_of(yarns)
    mass = yarns.masses_per_length(chosen.mass_per_length)[yarns.segment_yarn] * yarns.rest_length
    return replace(chosen, k_global=0.5 * drag * float(mass.mean()))


def _frames(
    follower: BodyFollower, run: Run[YarnSet], written: dict[str, str], *, resumed: bool
) -> Iterator[YarnFrame]:  # fmt: skip
    """Yield the frames; compare the linking at the end."""

    def next_frame() -> YarnFrame:
        began = time.perf_counter()
        with alone():
            follower.advance()
            return _frame(follower, time.perf_counter() - began)

    def checkpoint() -> CheckpointFile:
        state = follower.state()
        numbers = {name: value for name, value in vars(state).items() if name != "arrays"}
        return CheckpointFile({"inputs": written, **numbers}, state.arrays)

    first = None if resumed else lambda: _frame(follower, 0.0)
    last = len(follower.times) - 1
    yield from FrameRun("follow", last, first, next_frame, checkpoint, run).frames(follower.frame)
    refuse_pull_through(follower.inputs.yarns, follower.yarns(), str(follower.inputs.device))


def _frame(follower: BodyFollower, seconds: float) -> YarnFrame:
    report = {**follower.report(), "seconds": seconds}
    return YarnFrame(follower.frame, report["time"], follower.yarns(), report)


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
