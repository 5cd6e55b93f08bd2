# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knit a skirt, and let another program simulate its cloth while the waist turns to and fro, or on a moving body.

    pip install newton==1.8.0
    python examples/animate_skirt.py -o out/skirt
    stitchmesh animate out/skirt/stitches.h5 out/skirt/cloth.usdc -o out/skirt/animated --quality draft --sheet

The cloth solver (vertex block descent) and the writer of the USD file belong to Newton, a physics engine that
StitchMesh does not need. The cloth is the surface on which the stitches lie, so its first frame is where they are.
``--mesh skirt.obj --unit dm`` takes another skirt, whose rows are modelled and whose highest border is the waist.
``--body walk.usdc`` gives an animated body that is inside the skirt at its first frame: it carries the waist, and the
cloth collides with it.
"""

from __future__ import annotations

import argparse
from itertools import pairwise
from pathlib import Path

import numpy as np

import stitchmesh as sm

AROUND, ROWS = 60, 24
"""Quads around the skirt, and rows of them."""
WAIST, HEM, HEIGHT = 6.0, 11.0, 18.0
"""Radii of waist and hem, and height [cm]."""
FRAMES_PER_SECOND, SUBSTEPS = 30, 10
"""Frames and time steps."""
SWING, PERIOD, RAMP = 100.0, 1.2, 0.4
"""Largest turn of the waist [degrees], its period, and the time in which the turns grow to their full size [s]."""
REACH = 0.1
"""The part of a body that is higher or lower than the skirt by more than this [m] is left out."""


def skirt() -> sm.Mesh:
    """Return the skirt: rings of quads from the hem to the waist."""
    level, angle = np.linspace(0.0, 1.0, ROWS + 1)[:, None], np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)
    radius = HEM + (WAIST - HEM) * level
    vertices = np.stack([radius * np.sin(angle), HEIGHT * level + 0.0 * angle, radius * np.cos(angle)], axis=-1)
    ring = np.arange((ROWS + 1) * AROUND).reshape(ROWS + 1, AROUND)
    after = np.roll(ring, -1, axis=1)
    faces = np.stack([ring[:-1], after[:-1], after[1:], ring[1:]], axis=-1).reshape(-1, 4)
    return sm.Mesh.from_polygons(vertices.reshape(-1, 3), faces.tolist())


def turned(points: np.ndarray, time: float, swing: float) -> np.ndarray:
    """Return the points of the waist at a time [s], turned about the vertical line through their middle."""
    grown = min(time / RAMP, 1.0) ** 2 * (3.0 - 2.0 * min(time / RAMP, 1.0))
    angle = grown * np.radians(swing) * np.sin(2.0 * np.pi * time / PERIOD)
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    return points + (points - points.mean(axis=0)) @ (turn - np.eye(3)).T


class Turning:
    """A waist that turns to and fro, without a body."""

    def __init__(self, waist: np.ndarray, swing: float) -> None:
        """Turn the points of a waist [m], at most by ``swing`` degrees."""
        self.waist, self.swing = waist, swing

    def points(self, _time: float) -> np.ndarray:
        """Points of the body [m]."""
        return np.zeros((0, 3))

    def waist_at(self, time: float) -> np.ndarray:
        """Points of the waist at a time [s]."""
        return turned(self.waist, time, self.swing)


class Wearer:
    """A moving body that carries the waist of a skirt."""

    def __init__(self, body: sm.MovingMesh, skirt: np.ndarray, waist: np.ndarray) -> None:
        """Take the part of the body that the skirt can reach; ``waist`` are its points at the first frame [m]."""
        self.times, places = body.motion.times, 0.01 * body.motion.vertices
        low, high = skirt[:, 1].min() - REACH, skirt[:, 1].max() + REACH
        triangles = triangles_of(body.mesh)
        height = places[:, :, 1].mean(axis=0)[triangles]
        kept = triangles[((height > low) & (height < high)).all(axis=1)]
        used, corners = np.unique(kept, return_inverse=True)
        self.places, self.corners = places[:, used], corners.ravel()
        self.waist = waist
        self.carrier = np.array([np.linalg.norm(self.places[0] - point, axis=1).argmin() for point in waist])

    def points(self, time: float) -> np.ndarray:
        """Points of the body [m]."""
        frame = np.clip(np.interp(time, self.times, np.arange(len(self.times))), 0, len(self.times) - 1)
        first = min(int(frame), len(self.times) - 2)
        return self.places[first] + (frame - first) * (self.places[first + 1] - self.places[first])

    def waist_at(self, time: float) -> np.ndarray:
        """Points of the waist at a time [s]: each moves with the nearest point of the body."""
        return self.waist + (self.points(time) - self.places[0])[self.carrier]


def triangles_of(mesh: sm.Mesh) -> np.ndarray:
    """Triangles of the faces of a mesh, shape (n, 3)."""
    return np.array([(face[0], *pair) for face in mesh.polygons for pair in pairwise(face[1:])])


def simulate(mesh: sm.Mesh, path: Path, frames: int, swing: float = SWING, body: sm.MovingMesh | None = None) -> None:
    """Simulate the cloth of a skirt whose highest border is held by the waist, and write it in metres."""
    import newton
    import warp as wp
    from newton.viewer import ViewerUSD

    points, corners = 0.01 * mesh.vertices, triangles_of(mesh).ravel()
    borders = [mesh.face_vertex[loop] for loop in mesh.boundary_loops]
    waist = max(borders, key=lambda border: points[border, 1].mean())
    held = Turning(points[waist], swing) if body is None else Wearer(body, points, points[waist])
    builder = newton.ModelBuilder(up_axis=newton.Axis.Y)
    # the body is a cloth too, whose points do not obey forces: the solver keeps cloths apart
    cloths = [(points, corners), *([] if isinstance(held, Turning) else [(held.points(0.0), held.corners)])]
    for places, indices in cloths:
        builder.add_cloth_mesh(
            pos=wp.vec3(), rot=wp.quat_identity(), scale=1.0, vel=wp.vec3(), particle_radius=0.002,
            vertices=[wp.vec3(*place) for place in places], indices=indices.tolist(), density=0.3,
            tri_ke=3e2, tri_ka=3e2, tri_kd=1e-3, edge_ke=0.7, edge_kd=1e-5,
        )  # fmt: skip
    builder.color(include_bending=True)
    model = builder.finalize()
    flags = model.particle_flags.numpy()
    moved_by_hand = np.concatenate([waist, np.arange(len(points), len(flags))])
    flags[moved_by_hand] &= ~int(newton.ParticleFlags.ACTIVE)
    model.particle_flags.assign(flags)
    solver = newton.solvers.SolverVBD(
        model, iterations=10, particle_enable_self_contact=True, particle_self_contact_margin=0.002,
        particle_self_contact_gap=0.001,
    )  # fmt: skip
    now, after = model.state(), model.state()
    path.parent.mkdir(parents=True, exist_ok=True)
    viewer = ViewerUSD(str(path), fps=FRAMES_PER_SECOND, up_axis="Y", num_frames=frames)
    for frame in range(frames):
        time = frame / FRAMES_PER_SECOND
        viewer.begin_frame(time)
        viewer.log_mesh("cloth", wp.clone(now.particle_q[: len(points)]), wp.array(corners, dtype=wp.int32))
        viewer.end_frame()
        for step in range(1, SUBSTEPS + 1):
            moved = now.particle_q.numpy()
            then = time + step / (SUBSTEPS * FRAMES_PER_SECOND)
            moved[moved_by_hand] = np.concatenate([held.waist_at(then), held.points(then)])
            now.particle_q.assign(moved)
            after.particle_q.assign(moved)
            now.clear_forces()
            solver.step(now, after, None, None, 1.0 / (SUBSTEPS * FRAMES_PER_SECOND))
            now, after = after, now
    viewer.close()


def main(
    folder: Path, mesh: sm.Mesh, stitch_width: float = 1.0, frames: int = 60, swing: float = SWING,
    body: sm.MovingMesh | None = None,
) -> None:  # fmt: skip
    """Write the stitches and the moving cloth."""
    fabric = sm.tessellate(sm.label(mesh), stitch_width=stitch_width)
    fabric = sm.relax_mesh(fabric, surface=mesh).fabric
    sm.write_stitches(folder / "stitches.h5", fabric)
    print(f"{fabric.face_count} stitches")
    simulate(mesh, folder / "cloth.usdc", frames, swing, body)
    print(f"{frames} frames in {folder / 'cloth.usdc'}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=Path("out/skirt"), help="folder of the files")
    parser.add_argument("--mesh", type=Path, help="skirt of quads in rows (default: a small one)")
    parser.add_argument("--unit", default="cm", help="unit of the mesh")
    parser.add_argument("--stitch-width", type=float, default=1.0, help="width of a stitch [cm]")
    parser.add_argument("--frames", type=int, default=60, help="number of frames")
    parser.add_argument("--swing", type=float, default=SWING, help="largest turn of the waist [degrees]")
    parser.add_argument("--body", type=Path, help="animated body inside the skirt (default: none)")
    given = parser.parse_args()
    own = skirt() if given.mesh is None else sm.read_mesh(given.mesh, unit=given.unit)
    wearer = None if given.body is None else sm.read_moving_mesh(given.body)
    main(given.output, own, given.stitch_width, given.frames, given.swing, wearer)
