# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns that a moving cloth carries: motions in closed form, the full relaxation, the guard, resuming, and refusals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, Mesh, StitchMesh
from stitchmesh.mesh.connectivity import find_twins
from stitchmesh.mesh.vertex_motion import MovingMesh, best_rigid_place
from stitchmesh.patterns.swatch_mesh import plain_piece
from stitchmesh.quality import PRESETS
from stitchmesh.run import CHECKPOINT, QUIET, Checkpoints
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.animate_yarns import animate_yarns
from stitchmesh.yarnrelax.animator import AnimationInputs, Animator
from stitchmesh.yarnrelax.missed_frames import sharpest_fold
from stitchmesh.yarnrelax.motion.animation_options import AnimationOptions

COLUMNS, ROWS, WIDTH = 6, 6, 1.0
EXACT = replace(PRESETS["draft"], precision="float64", tolerance=1e-4, largest_change=4e-4)
"""At rest so far that the rest does not depend on where a relaxation began."""
FEW = AnimationOptions(iterations=5, first_iterations=20)


def sheet(height: float = 0.0) -> Mesh:
    """The plane of the swatch as quads that are no stitches, at a height."""
    x, y = (grid.ravel() for grid in np.meshgrid(np.linspace(0, COLUMNS, 5), np.linspace(0, ROWS, 4), indexing="ij"))
    corner = np.arange(20).reshape(5, 4)
    faces = np.stack([corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]], axis=-1).reshape(-1, 4)
    return Mesh.from_polygons(np.stack([x, y, np.full(20, height)], axis=1), faces.tolist())


def moving(mesh: Mesh, places: list[Callable[[FloatArray], FloatArray]]) -> MovingMesh:
    """A mesh that some functions move, one for each frame."""
    frames = [replace(mesh, vertices=place(mesh.vertices)) for place in places]
    return MovingMesh.of_frames(frames, np.arange(len(frames)) / 30.0)


@cache
def swatch() -> tuple[StitchMesh, YarnSet]:
    """A flat swatch, and its yarns relaxed."""
    fabric = plain_piece(COLUMNS, ROWS, WIDTH, WIDTH)
    drawn = generate_yarns(fabric, quality="draft")
    return fabric, relax_yarns(drawn, quality=EXACT, device="cpu", keep_shape=fabric, run=QUIET).yarns


def frames(cloth: MovingMesh, options: AnimationOptions = FEW, **more: Any) -> list[Any]:
    fabric, yarns = swatch()
    given = {"quality": EXACT, "device": "cpu", "run": QUIET} | more
    return list(animate_yarns(yarns, fabric, cloth, options=options, **given))


def rms(one: YarnSet, other: YarnSet) -> float:
    """Root mean square of the distances of control points, over the radius."""
    apart = np.linalg.norm(one.points - other.points, axis=1)
    return float(np.sqrt((apart**2).mean()) / one.radius.mean())


def turned(angle: float) -> FloatArray:
    """A turn about x."""
    return np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])


def same(points: FloatArray) -> FloatArray:
    return points


def bent(angle: float) -> Callable[[FloatArray], FloatArray]:
    """Bend the plane to a cylinder about an axis along y, whose arc has an angle."""

    def place(points: FloatArray) -> FloatArray:
        if angle == 0.0:
            return points
        radius = COLUMNS / angle
        turn = (points[:, 0] - 0.5 * COLUMNS) / radius
        out = radius + points[:, 2]
        return np.stack([0.5 * COLUMNS + out * np.sin(turn), points[:, 1], out * np.cos(turn) - radius], axis=1)

    return place


def test_yarns_follow_a_rigid_motion_exactly() -> None:
    turn, shift = turned(1.2), np.array([300.0, -50.0, 20.0])
    still = frames(moving(sheet(), [same, same, same]))
    rigid = frames(moving(sheet(), [same, lambda points: points @ turn.T + shift, lambda points: points - shift]))
    # rounding of coordinates of 300 cm in double precision, which ten iterations of contacts enlarge
    np.testing.assert_allclose(rigid[1].yarns.points, still[1].yarns.points @ turn.T + shift, atol=1e-9)
    np.testing.assert_allclose(rigid[2].yarns.points, still[2].yarns.points - shift, atol=1e-9)


def test_the_best_rigid_place_is_the_motion_itself() -> None:
    points, turn, shift = np.random.default_rng(3).normal(size=(20, 3)), turned(2.5), np.array([1.0, 2.0, 3.0])
    place = best_rigid_place(points, points @ turn.T + shift)
    np.testing.assert_allclose(place.rotation, turn, atol=1e-13)  # rounding
    np.testing.assert_allclose(place.brought_back(place.moved(points)), points, atol=1e-13)
    mirrored = best_rigid_place(points, points * np.array([1.0, 1.0, -1.0]))
    assert np.linalg.det(mirrored.rotation) == pytest.approx(1.0)


def test_an_affine_motion_in_the_plane_carries_points_affinely_and_keeps_their_height() -> None:
    fabric, yarns = swatch()
    stretch = np.array([[1.03, 0.02, 0.0], [-0.01, 0.97, 0.0], [0.0, 0.0, 1.0]])
    cloth = moving(sheet(), [same, lambda points: points @ stretch.T])
    material = YarnMaterial.named().of_radius(float(yarns.radius.mean()))
    animator = Animator(AnimationInputs(yarns, fabric, cloth, material, EXACT, 1, device_named("cpu")))
    figures = animator.advance()
    carried, moved = animator.carried(1)
    # the height is along the normal, so the motion is affine for points off the plane too; rounding
    np.testing.assert_allclose(carried.points, yarns.points @ stretch.T, atol=1e-12)
    np.testing.assert_allclose(moved.vertices, fabric.vertices @ stretch.T, atol=1e-12)
    assert figures.passed == 1.0


def test_a_still_cloth_keeps_yarns_at_rest() -> None:
    made = frames(moving(sheet(), [same] * 4), AnimationOptions(iterations=5, first_iterations=2000))
    assert [frame.report["missed"] for frame in made] == [None] * 4
    # at this residual the remaining motion of 15 iterations is far below the goal of 0.2 radii
    assert rms(made[-1].yarns, made[0].yarns) < 0.01


def test_frames_of_few_iterations_are_near_those_that_come_to_rest_and_more_iterations_bring_them_nearer() -> None:
    """The rest is that of the same frames with very many iterations.

    It is not a relaxation of the carried yarns on their own: that keeps another shape, and without friction the loops
    have soft motions of 0.2 radii, so another start, or another processor, ends elsewhere.
    """
    cloth = moving(sheet(), [bent(angle) for angle in [0.0, 0.1, 0.2, 0.2, 0.2, 0.2]])
    few, many, rest = (
        frames(cloth, AnimationOptions(iterations=count, first_iterations=2000)) for count in (5, 100, 1000)
    )
    assert all(frame.report["missed"] is None for frame in few)
    assert rms(few[-1].yarns, few[0].yarns) > 0.5
    # with the given yarns shaken by up to 1e-3 cm: 0.11 to 0.14 radii after 5 iterations, and 0.05 to 0.11 after 100
    assert rms(few[-1].yarns, rest[-1].yarns) < 0.2
    assert rms(many[-1].yarns, rest[-1].yarns) < 0.85 * rms(few[-1].yarns, rest[-1].yarns)


def two_layers() -> tuple[StitchMesh, YarnSet, Mesh]:
    """Two flat swatches, one a stitch above the other, and the sheets on which they lie."""
    one = plain_piece(COLUMNS, ROWS, WIDTH, WIDTH)
    vertices = np.concatenate([one.vertices, one.vertices + np.array([0.0, 0.0, WIDTH])])
    corners = np.concatenate([one.face_vertex, one.face_vertex + len(one.vertices)])
    start = np.append(one.face_start, one.face_start[1:] + len(one.face_vertex))
    twice = {name: np.tile(getattr(one, name), 2) for name in ("n_bottom", "n_top", "stitch", "row")}
    fabric = StitchMesh(vertices=vertices, face_start=start, face_vertex=corners,
                        twin=find_twins(start, corners, len(vertices)), **twice)  # fmt: skip
    low, high = sheet(), sheet(WIDTH)
    faces = [face.tolist() for face in np.split(low.face_vertex, low.face_start[1:-1])]
    more = [[corner + len(low.vertices) for corner in face] for face in faces]
    cloth = Mesh.from_polygons(np.concatenate([low.vertices, high.vertices]), faces + more)
    return fabric, generate_yarns(fabric, quality="draft"), cloth


def test_the_guard_stops_a_layer_that_would_pass_through_another_one_and_the_report_names_the_frame() -> None:
    fabric, yarns, layers = two_layers()
    down = np.where(layers.vertices[:, 2:] > 0.5, [[0.0, 0.0, -2.0 * WIDTH]], 0.0)
    cloth = moving(layers, [same, same, lambda points: points + down])
    made = list(animate_yarns(yarns, fabric, cloth, quality="draft", device="cpu", options=FEW, run=QUIET))
    assert [frame.report["missed"] is None for frame in made] == [True, True, False]
    assert "the guard stopped yarn" in made[2].report["missed"]
    assert 0.0 < made[2].report["passed"] < 1.0
    upper = yarns.points[:, 2] > 0.5 * WIDTH
    moved = made[2].yarns.points[:, 2]
    assert moved[upper].mean() > moved[~upper].mean()  # on its side still
    assert made[2].report["certified"]


def test_a_cloth_that_cuts_through_itself_is_named_and_one_that_does_so_at_the_start_is_refused() -> None:
    fabric, yarns, layers = two_layers()

    def crossed(points: FloatArray) -> FloatArray:
        upper = points[:, 2:] > 0.5
        tilt = 2.0 * WIDTH * (points[:, :1] / COLUMNS - 0.4) - WIDTH
        return points + np.where(upper, np.concatenate([0.0 * tilt, 0.1 + 0.0 * tilt, tilt], axis=1), 0.0)

    cloth = moving(layers, [same, crossed])
    given: dict[str, Any] = {"quality": "draft", "device": "cpu", "options": FEW, "run": QUIET}
    made = list(animate_yarns(yarns, fabric, cloth, **given))
    assert "cuts through face" in made[1].report["cloth"]
    assert made[1].report["missed"].startswith("cloth in cloth near")
    first = replace(layers, vertices=crossed(layers.vertices))
    with pytest.raises(ParameterError, match=r"cloth: frame 0, near .* cm: face \d+ cuts through face"):
        animate_yarns(yarns, fabric, moving(first, [same]), **given)


def test_a_fold_tighter_than_a_stitch_is_found() -> None:
    fabric, _yarns = swatch()
    folded = fabric.vertices.copy()
    beyond = folded[:, 0] > 3.0
    folded[beyond] = np.stack([6.0 - folded[beyond, 0], folded[beyond, 1], np.full(beyond.sum(), 0.3)], axis=1)
    first, second, angle = sharpest_fold(replace(fabric, vertices=folded))
    assert sorted((first % COLUMNS, second % COLUMNS)) in ([2, 3], [3, 4])
    assert angle > np.radians(90.0)
    assert sharpest_fold(fabric)[2] == pytest.approx(0.0, abs=1e-7)  # the arc cosine of a number near 1


def test_a_resumed_run_has_the_bits_of_one_that_never_stopped(tmp_path: Path) -> None:
    cloth = moving(sheet(), [bent(angle) for angle in (0.0, 0.2, 0.4, 0.6)])
    whole = frames(cloth)
    kept = replace(QUIET, checkpoints=Checkpoints(tmp_path, 1))
    fabric, yarns = swatch()
    begun = animate_yarns(yarns, fabric, cloth, quality=EXACT, device="cpu", options=FEW, run=kept)
    assert [next(begun).number for _ in range(3)] == [0, 1, 2]  # the checkpoint is of frame 1
    begun.close()
    resumed = replace(kept, resume=tmp_path / CHECKPOINT)
    rest = frames(cloth, run=resumed)
    assert [frame.number for frame in rest] == [2, 3]
    for found, expected in zip(rest, whole[2:], strict=True):
        np.testing.assert_array_equal(found.yarns.points, expected.yarns.points)
        assert {**found.report, "seconds": 0} == {**expected.report, "seconds": 0}
    with pytest.raises(ParameterError, match=r"options.iterations is 6 and was 5; give it the same"):
        frames(cloth, replace(FEW, iterations=6), run=resumed)


def test_a_cloth_that_is_not_where_the_fabric_is_and_other_wrong_inputs_are_refused() -> None:
    _fabric, yarns = swatch()
    with pytest.raises(ParameterError, match=r"from the cloth of frame 0; expected at most 2 cm, 2 stitches; give the"):
        frames(moving(sheet(5.0), [same]))
    with pytest.raises(ParameterError, match="got no frame; expected at least one"):
        MovingMesh.of_frames([], [])
    other = plain_piece(2, 2, WIDTH, WIDTH)
    with pytest.raises(ParameterError, match="pass its own"):
        animate_yarns(yarns, other, moving(sheet(), [same]), device="cpu")
    with pytest.raises(ParameterError, match="iterations: got 0; expected a number of iterations"):
        AnimationOptions(iterations=0)
