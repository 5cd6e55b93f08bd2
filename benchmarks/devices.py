# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The same yarns on two devices: how far forces and relaxed states lie apart, and whether a device repeats itself.

    python benchmarks/devices.py --device cpu --save cpu.npz
    python benchmarks/devices.py --device cuda:0 --compare cpu.npz

The scene, a generated and relaxed hat, is kept in the file, so that both runs start from the same bits.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import stitchmesh as sm
from stitchmesh.yarnrelax.material import REFERENCE_RADIUS

HAT = Path(__file__).resolve().parent.parent / "assets" / "meshes" / "hat.obj"


def results(yarns: sm.YarnSet, device: str) -> dict[str, np.ndarray]:
    """Forces [dyn] in both precisions and the relaxed control points [cm], which must be the same twice."""
    material = sm.YarnMaterial.named("stitchmesh").scaled(yarns.radius[0] / REFERENCE_RADIUS)
    forces = {name: sm.yarn_forces(yarns, material, precision=name, device=device) for name in ("float64", "float32")}
    runs = [sm.relax_yarns(yarns, quality="draft", device=device) for _ in range(2)]
    same = np.array_equal(runs[0].yarns.points, runs[1].yarns.points)
    report = runs[1].report
    agree = "agree" if same else "differ"
    print(f"{device}: {len(yarns.points)} control points, {report['iterations']} iterations, {report['seconds']:.2f} s")
    print(f"residual {report['residual']:.2g}; two runs {agree} in their bits")
    return {**forces, "relaxed": runs[0].yarns.points}


def compare(mine: dict[str, np.ndarray], theirs: dict[str, np.ndarray], radius: float) -> None:
    """Print largest differences."""
    for name in ("float64", "float32"):
        largest = np.abs(theirs[name]).max()
        print(f"forces, {name}: {np.abs(mine[name] - theirs[name]).max() / largest:.2g} of the largest")
    apart = np.linalg.norm(mine["relaxed"] - theirs["relaxed"], axis=1).max() / radius
    print(f"relaxed control points: {apart:.2g} radii apart at most")


def main() -> None:
    """Save one device's results or compare another's with them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--device", required=True)
    choice = parser.add_mutually_exclusive_group(required=True)
    choice.add_argument("--save", type=Path)
    choice.add_argument("--compare", type=Path)
    given = parser.parse_args()
    if given.save:
        fabric = sm.tessellate(sm.label(sm.read_mesh(HAT)), stitch_width=0.8)
        yarns = sm.generate_yarns(fabric, quality="draft")
        sm.write_yarns(given.save.with_suffix(".h5"), yarns)
        np.savez(given.save, **results(yarns, given.device))
        return
    yarns = sm.read_yarns(given.compare.with_suffix(".h5"))
    compare(results(yarns, given.device), dict(np.load(given.compare)), float(yarns.radius[0]))


if __name__ == "__main__":
    main()
