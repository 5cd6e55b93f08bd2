# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns on a cloth that moves: the order of operations, and what is proved about the frames.

At the first frame the yarns come to rest on the cloth. Every other frame is made from the one before (``animator``). No
yarn passes through another one on the way, because the guard bounds each travel and the step limit bounds each
iteration. This holds for frames that are missed too. The linking of all yarns is compared, as exact integers, with the
linking of the given yarns (``linking.certificate``) at the first frame, at each ``certify_every``-th one and at the
last one. It does not depend on the guard.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import warp as wp

from stitchmesh import __version__
from stitchmesh.compute.device import alone, device_named
from stitchmesh.errors import ParameterError, SolverError, check_kind
from stitchmesh.io.checkpoint_file import CheckpointFile
from stitchmesh.linking.certificate import DoubledLinking, doubled_linking, refuse_changed_linking
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.vertex_motion import MovingMesh
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.run import SHOWN, Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.animator import AnimationInputs, Animator, FrameFigures
from stitchmesh.yarnrelax.fingerprint import fingerprint, yarn_fingerprint
from stitchmesh.yarnrelax.frame_run import FrameHeader, FrameRun, YarnFrame, checkpoint_of
from stitchmesh.yarnrelax.missed_frames import why_missed
from stitchmesh.yarnrelax.model.material import YarnMaterial, material_of
from stitchmesh.yarnrelax.motion.animation_options import AnimationOptions
from stitchmesh.yarnrelax.motion.carried_points import distances_from_mesh
from stitchmesh.yarnrelax.motion.self_cuts import SelfCuts

FARTHEST = 2.0
"""Largest distance of a stitch from the cloth of the first frame, in mean widths of the stitches."""


@dataclass(frozen=True, eq=False)
class _Course:
    """What all frames of a run need."""

    animator: Animator
    cuts: SelfCuts
    linking: DoubledLinking
    """Linking of the given yarns."""
    options: AnimationOptions


def animate_yarns(
    yarns: YarnSet,
    fabric: StitchMesh,
    cloth: MovingMesh,
    *,
    material: YarnMaterial | None = None,
    quality: str | Quality = DEFAULT_QUALITY,
    device: str | None = None,
    options: AnimationOptions | None = None,
    run: Run[YarnSet] = SHOWN,
) -> Iterator[YarnFrame]:
    """Carry yarns with a cloth that moves, relax them in each frame, and yield them. All arguments are checked first.

    The report of a frame has the keys ``frame``, ``time`` [s], ``passed`` (part of the way from the frame before that
    the yarns have travelled, 1 if the frame is reached), ``missed`` (why it is not reached or not relaxed; None if it
    is both), ``cloth`` (where the cloth cuts through itself; None if it does not), ``min_distance_over_radius``,
    ``need`` (largest approach of two yarns on the way, over the approach that one travel allows), ``travels``,
    ``attempts``, ``certified`` (whether the linking of all yarns was compared) and ``seconds``.

    Args:
        yarns: yarns of the fabric, without a lattice, for example relaxed by ``relax_yarns``.
        fabric: the stitch mesh from which they were generated.
        cloth: the moving surface on which the fabric lies; its first frame is where the fabric is.
        material: stiffnesses; None for the material ``stitchmesh``, scaled to the radius of the yarns.
        quality: a preset or a ``Quality``; its solver is not used.
        device: "cpu", "cuda:0" ...; None for the first GPU, or the CPU if there is no GPU.
        options: numbers of iterations and of certificates.
        run: progress, checkpoints, whose interval is counted in frames, and the checkpoint to resume. If that file does
            not exist yet, the run begins at the first frame. The frames of a resumed run have the bits of a run that
            never stopped.

    Yields:
        The yarns at each frame; a resumed run yields only the frames after its checkpoint.

    Raises:
        ParameterError: a choice does not fit, the cloth is not where the fabric is or cuts through itself at the first
            frame, or the checkpoint belongs to a run with other inputs.
        FileError: a checkpoint cannot be written or read.
        SolverError: yarns are too close to each other at the first frame, or the linking of two yarns has changed; the
            message names the frame.
    """
    check_kind("animate", yarns, YarnSet)
    check_kind("animate", fabric, StitchMesh)
    check_kind("animate", cloth, MovingMesh)
    if yarns.lattice is not None:
        raise ParameterError("animate: got yarns on a lattice; expected a piece without one, as knit makes it")
    run.refuse_all_but("animate", "checkpoints", "resume")
    chosen, own = quality_named(quality), material or material_of(yarns)
    given = options or AnimationOptions()
    inputs = AnimationInputs(yarns, fabric, cloth, own, chosen, given.iterations, device_named(device))
    with alone():
        refuse_wrong_cloth(fabric, cloth, inputs.device)
        animator = Animator(inputs)
        linking = doubled_linking(yarns, device=str(inputs.device))
        written = _fingerprints(inputs, given) if run.checkpoints is not None or run.resume is not None else {}
        course = _Course(animator, SelfCuts(cloth.mesh, inputs.device), linking, given)
        resumed = checkpoint_of(run, written, FrameHeader)
        if resumed is not None:
            animator.resume(resumed[0]["frame"], resumed[1])
    last = len(cloth.motion.times) - 1
    first = partial(_first_frame, course) if resumed is None else None
    frames = FrameRun("animate", last, first, partial(_next_frame, course), partial(_checkpoint, course, written), run)
    return frames.frames(animator.frame)


def refuse_wrong_cloth(fabric: StitchMesh, cloth: MovingMesh, device: wp.Device) -> None:
    """Check that a fabric lies on the first frame of a cloth, which does not cut through itself.

    Raises:
        ParameterError: the frame cuts through itself, or a vertex of the fabric is too far from it.
    """
    cut = SelfCuts(cloth.mesh, device).first(cloth.motion.vertices[0])
    if cut is not None:
        raise ParameterError(f"cloth: frame 0, {cut}; expected a first frame that does not cut itself; begin later")
    first = replace(cloth.mesh, vertices=cloth.motion.vertices[0])
    distance = distances_from_mesh(first, fabric.vertices, device)
    most = FARTHEST * float(np.sqrt(np.linalg.norm(fabric.face_vector_area, axis=1).mean()))
    worst = int(distance.argmax())
    if distance[worst] > most:
        found = f"vertex {worst} of the stitch mesh is {distance[worst]:.3g} cm from the cloth of frame 0"
        expected = f"expected at most {most:.3g} cm, {FARTHEST:g} stitches"
        remedy = "give the unit and the direction up of the cloth, begin elsewhere, or subdivide it as the mesh was"
        raise ParameterError(f"cloth: {found}; {expected}; {remedy}")


def _checkpoint(course: _Course, written: dict[str, str]) -> CheckpointFile:
    return CheckpointFile({"inputs": written, "frame": course.animator.frame}, course.animator.arrays())


def _first_frame(course: _Course) -> YarnFrame:
    began = time.perf_counter()
    with alone():
        return _frame(course, course.animator.come_to_rest(course.options.first_iterations), began)


def _next_frame(course: _Course) -> YarnFrame:
    began = time.perf_counter()
    with alone():
        return _frame(course, course.animator.advance(), began)


def _frame(course: _Course, figures: FrameFigures, began: float) -> YarnFrame:
    """Return the present frame with its report."""
    animator, motion = course.animator, course.animator.inputs.cloth.motion
    number, yarns = animator.frame, animator.yarns()
    cut = course.cuts.first(motion.vertices[number]) if number else None
    missed = None
    if figures.stopped_at is not None:
        missed = why_missed(yarns, animator.carried(number)[1], figures.stopped_at, cut)
    elif figures.unrelaxed:
        missed = "the yarns were carried but not relaxed: the cloth deforms them too much; give it more frames"
    certified = number % course.options.certify_every == 0 or number == len(motion.times) - 1
    if certified:
        _certify(course, yarns, number)
    when = float(motion.times[number])
    report = {
        "frame": number,
        "time": when,
        "passed": figures.passed,
        "missed": missed,
        "cloth": None if cut is None else str(cut),
        "min_distance_over_radius": figures.nearest,
        "need": figures.need,
        "travels": figures.travels,
        "attempts": figures.attempts,
        "certified": certified,
        "seconds": time.perf_counter() - began,
    }
    return YarnFrame(number, when, yarns, report)


def _certify(course: _Course, yarns: YarnSet, number: int) -> None:
    inputs = course.animator.inputs
    try:
        refuse_changed_linking(inputs.yarns, yarns, course.linking, str(inputs.device))
    except SolverError as error:
        raise SolverError(f"frame {number}: {error}") from error


def _fingerprints(inputs: AnimationInputs, options: AnimationOptions) -> dict[str, str]:
    """Return everything that decides a run, as short strings."""
    found: dict[str, Any] = {"stitchmesh": __version__, "device": "cuda" if inputs.device.is_cuda else "cpu"}
    found |= yarn_fingerprint(inputs.yarns)
    found |= fingerprint("material", inputs.material)
    found |= fingerprint("quality", inputs.quality)
    found |= fingerprint("fabric", inputs.fabric)
    found |= fingerprint("cloth", inputs.cloth)
    found |= fingerprint("options", options)
    return found
