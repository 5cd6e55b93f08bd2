# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The yarn that a set of yarns carries."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.errors import FileError
from stitchmesh.io import read_yarns, write_yarns
from stitchmesh.pipeline.options import RelaxOptions
from stitchmesh.pipeline.yarn_relaxation import relax_with_options
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.beside import yarns_beside
from stitchmesh.yarn.yarn_presets import Yarn
from stitchmesh.yarnrelax.model.material import YarnMaterial, material_of

RING = np.stack([np.cos(np.arange(8) * np.pi / 4), np.sin(np.arange(8) * np.pi / 4), np.zeros(8)], axis=1)


def ring(name: str | None) -> YarnSet:
    yarns = YarnSet.from_curves([RING], closed=[True], radius=0.05)
    return replace(yarns, made_of=None if name is None else Yarn.named(name))


@pytest.mark.parametrize("name", ["dk", "cotton-elastane", None])
def test_a_file_keeps_the_yarn(name: str | None, tmp_path: Path) -> None:
    write_yarns(tmp_path / "yarns.h5", ring(name))
    assert read_yarns(tmp_path / "yarns.h5").made_of == ring(name).made_of


def test_a_damaged_yarn_is_refused(tmp_path: Path) -> None:
    import h5py

    write_yarns(tmp_path / "yarns.h5", ring("dk"))
    with h5py.File(tmp_path / "yarns.h5", "a") as file:
        del file["made_of"]
        file.create_dataset("made_of", data=np.frombuffer(b"{}", np.uint8))
    with pytest.raises(FileError, match=r"yarns\.h5"):
        read_yarns(tmp_path / "yarns.h5")


@pytest.mark.parametrize("name", ["dk", "cotton-elastane"])
def test_the_material_is_that_of_the_yarn_given_by_hand(name: str) -> None:
    by_hand = RelaxOptions(material=YarnMaterial.named(name), stiffness={"k_bend": 2.0})
    assert RelaxOptions(stiffness={"k_bend": 2.0}).yarn_material(ring(name)) == by_hand.yarn_material(ring(None))
    assert material_of(ring(name)) != material_of(ring(None))
    assert material_of(ring(name), "leaf") == material_of(ring(None), "leaf")


def test_a_joint_set_keeps_one_yarn_only() -> None:
    assert yarns_beside([ring("dk"), ring("dk")]).made_of is not None
    assert yarns_beside([ring("dk"), ring("lace")]).made_of is None


def test_relaxing_again_has_the_energies_of_the_yarn_given_by_hand() -> None:
    by_hand = relax_with_options(ring("dk"), RelaxOptions(material=YarnMaterial.named("dk")), quality="draft")
    carried = relax_with_options(ring("dk"), RelaxOptions(), quality="draft")
    assert carried.report["energies"] == by_hand.report["energies"]
    assert carried.report["made_of"] == "dk"
    assert "made_of" not in by_hand.report
