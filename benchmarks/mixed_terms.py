# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Time of the energies of the mixed system: forces, linearization, products of the Hessian and energy of each term.

    python benchmarks/mixed_terms.py
    python benchmarks/mixed_terms.py --triangles 1000 100000 --precision float64 --device cpu

The cloth is a square of irregular triangles, wavy in space, with a seam along its middle. Launches are captured, as a
solver repeats them. Each time is the shortest of some runs, because other programs may use the same cores; the time of
an energy contains reading it back to the host. The last column is the time of one product per element, where an element
is a triangle, a hinge, an edge of a seam or a contact point.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
import warp as wp
from scipy.spatial import Delaunay

from stitchmesh.compute.captured import CapturedLaunches
from stitchmesh.compute.device import device_named
from stitchmesh.compute.launch import prepare
from stitchmesh.compute.precision import scalar_named
from stitchmesh.compute.threads import set_threads
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.term import Term
from stitchmesh.mixed.triangles.measured_cloths import named_material
from stitchmesh.mixed.triangles.membrane import Membrane
from stitchmesh.mixed.triangles.seam_material import SeamMaterial
from stitchmesh.mixed.triangles.seam_rod import SeamRod
from stitchmesh.mixed.triangles.shell_bending import ShellBending

COLUMNS = ("elements", "forces", "linearize", "product", "energy", "ns/element")
LEAST_RUN = 0.2
"""Time of a run [s], of as many repetitions as it takes."""


def wavy_cloth(triangles: int, edge: float = 0.5) -> Cloth:
    """A square of about that number of irregular triangles with edges of about ``edge`` [cm], rolled and waved."""
    count = max(round((triangles / 2.0) ** 0.5), 2) // 2 * 2
    x, y = (part.ravel() for part in np.meshgrid(np.arange(count + 1.0), np.arange(count + 1.0)))
    inner = (x > 0) & (x < count) & (y > 0) & (y < count) & (x != count // 2)
    plane = np.column_stack([x, y])
    plane[inner] += np.random.default_rng(0).uniform(-0.2, 0.2, size=(int(inner.sum()), 2))
    corners = _anticlockwise(plane)
    plane *= edge
    middle = np.flatnonzero(x == count // 2)
    wave = np.sin(plane[:, 0] / 3.0) * np.cos(plane[:, 1] / 5.0)
    return Cloth(
        vertices=np.column_stack([1.02 * plane[:, 0], 0.99 * plane[:, 1], wave]),
        triangles=corners,
        rest=plane[corners],
        panel=np.zeros(len(corners), dtype=int),
        panel_names=("square",),
        seam_edges=np.column_stack([middle[:-1], middle[1:]]),
        seam_start=np.array([0, count]),
        seam_angle=np.array([0.3]),
    )


def _anticlockwise(plane: np.ndarray) -> np.ndarray:
    """Delaunay triangles with area, anticlockwise."""
    corners = Delaunay(plane).simplices
    one, other = plane[corners[:, 1]] - plane[corners[:, 0]], plane[corners[:, 2]] - plane[corners[:, 0]]
    doubled = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    turned: np.ndarray = np.where((doubled < 0.0)[:, None], corners[:, ::-1], corners)[np.abs(doubled) > 1e-6]
    return turned


def terms_of(cloth: Cloth, scalar: Any, device: wp.Device) -> Iterator[tuple[Term, int]]:
    """The terms that are measured, with their numbers of elements."""
    material = named_material("interlock")
    yield Membrane(cloth, material, scalar, device), len(cloth.triangles)
    yield ShellBending(cloth, material, scalar, device), len(cloth.hinges)
    yield SeamRod(cloth, SeamMaterial(1e5, 1.0), scalar, device), len(cloth.seam_edges)


def seconds(action: Callable[[], object], device: wp.Device, runs: int) -> float:
    """Shortest mean time of an action [s]."""

    def timed(repeats: int) -> float:
        wp.synchronize_device(device)
        began = time.perf_counter()
        for _ in range(repeats):
            action()
        wp.synchronize_device(device)
        return (time.perf_counter() - began) / repeats

    timed(1)
    repeats = max(1, int(LEAST_RUN / max(timed(1), 1e-6)))
    return min(timed(repeats) for _ in range(runs))


def measure(term: Term, elements: int, state: MixedVector, runs: int) -> tuple[float, ...]:
    """A row of the table: elements, times [ms] and the time of a product per element [ns]."""
    launcher = partial(prepare, device=state.device)
    result, direction = state.like(), state.copy()
    groups = [
        term.forces(state, result, launcher),
        term.linearize(state, launcher),
        term.products(direction, result, launcher),
    ]
    times = []
    for launches in groups:
        captured = CapturedLaunches(launches, state.device) if launches else None
        times.append(seconds(captured.launch, state.device, runs) if captured else 0.0)
    times.append(seconds(lambda: term.energy(state), state.device, runs))
    return (elements, *(1e3 * value for value in times), 1e9 * times[2] / elements)


def main() -> None:
    """Print a table for each size."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--triangles", type=int, nargs="+", default=[100_000])
    parser.add_argument("--precision", default="float32", help="float32 or float64")
    parser.add_argument("--device", default=None, help="Warp's name; the first GPU, or the CPU")
    parser.add_argument("--threads", type=int, default=None, help="threads on a CPU; all cores")
    parser.add_argument("--runs", type=int, default=3, help="runs of which the shortest is taken")
    arguments = parser.parse_args()
    device, scalar = device_named(arguments.device), scalar_named(arguments.precision)
    if arguments.threads:
        set_threads(arguments.threads)
    for triangles in arguments.triangles:
        cloth = wavy_cloth(triangles)
        state = MixedVector.from_numpy(cloth.vertices, [], [], scalar, device)
        print(f"{len(cloth.triangles)} triangles, {arguments.precision} on {device.name}; times in ms")
        print(f"{'':20s}" + "".join(f"{name:>12s}" for name in COLUMNS))
        for term, elements in terms_of(cloth, scalar, device):
            row = measure(term, elements, state, arguments.runs)
            print(
                f"{term.name:20s}{row[0]:12.0f}" + "".join(f"{value:12.3f}" for value in row[1:-1]) + f"{row[-1]:12.1f}"
            )


if __name__ == "__main__":
    main()
