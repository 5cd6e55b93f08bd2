# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knit a skirt, and let another program simulate its cloth while the waist turns to and fro.

    pip install newton==1.8.0
    python examples/animate_skirt.py -o out/skirt
    stitchmesh animate out/skirt/stitches.h5 out/skirt/cloth.usdc -o out/skirt/animated --quality draft --sheet

The cloth solver (vertex block descent) and the writer of the USD file belong to Newton, a physics engine that
StitchMesh does not need. The cloth is the surface on which the stitches lie, so its first frame is where they are.
``--mesh skirt.obj --unit dm`` takes another skirt, whose rows are modelled and whose highest border is the waist.
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


def simulate(mesh: sm.Mesh, path: Path, frames: int, swing: float = SWING) -> None:
    """Simulate the cloth of a skirt whose highest border is held by a waist that turns, and write it in metres."""
    import newton
    import warp as wp
    from newton.viewer import ViewerUSD

    points = 0.01 * mesh.vertices
    corners = np.array([(face[0], *pair) for face in mesh.polygons for pair in pairwise(face[1:])]).ravel()
    builder = newton.ModelBuilder(up_axis=newton.Axis.Y)
    builder.add_cloth_mesh(
        pos=wp.vec3(), rot=wp.quat_identity(), scale=1.0, vel=wp.vec3(), vertices=[wp.vec3(*point) for point in points],
        indices=corners.tolist(), density=0.3, tri_ke=3e2, tri_ka=3e2, tri_kd=1e-3, edge_ke=0.7, edge_kd=1e-5,
        particle_radius=0.002,
    )  # fmt: skip
    builder.color(include_bending=True)
    model = builder.finalize()
    borders = [mesh.face_vertex[loop] for loop in mesh.boundary_loops]
    waist = max(borders, key=lambda border: points[border, 1].mean())
    flags = model.particle_flags.numpy()
    flags[waist] &= ~int(newton.ParticleFlags.ACTIVE)
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
        viewer.log_mesh("cloth", now.particle_q, wp.array(corners, dtype=wp.int32))
        viewer.end_frame()
        for step in range(1, SUBSTEPS + 1):
            moved = now.particle_q.numpy()
            moved[waist] = turned(points[waist], time + step / (SUBSTEPS * FRAMES_PER_SECOND), swing)
            now.particle_q.assign(moved)
            after.particle_q.assign(moved)
            now.clear_forces()
            solver.step(now, after, None, None, 1.0 / (SUBSTEPS * FRAMES_PER_SECOND))
            now, after = after, now
    viewer.close()


def main(folder: Path, mesh: sm.Mesh, stitch_width: float = 1.0, frames: int = 60, swing: float = SWING) -> None:
    """Write the stitches and the moving cloth."""
    fabric = sm.tessellate(sm.label(mesh), stitch_width=stitch_width)
    fabric = sm.relax_mesh(fabric, surface=mesh).fabric
    sm.write_stitches(folder / "stitches.h5", fabric)
    print(f"{fabric.face_count} stitches")
    simulate(mesh, folder / "cloth.usdc", frames, swing)
    print(f"{frames} frames in {folder / 'cloth.usdc'}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=Path("out/skirt"), help="folder of the files")
    parser.add_argument("--mesh", type=Path, help="skirt of quads in rows (default: a small one)")
    parser.add_argument("--unit", default="cm", help="unit of the mesh")
    parser.add_argument("--stitch-width", type=float, default=1.0, help="width of a stitch [cm]")
    parser.add_argument("--frames", type=int, default=60, help="number of frames")
    parser.add_argument("--swing", type=float, default=SWING, help="largest turn of the waist [degrees]")
    given = parser.parse_args()
    own = skirt() if given.mesh is None else sm.read_mesh(given.mesh, unit=given.unit)
    main(given.output, own, given.stitch_width, given.frames, given.swing)
