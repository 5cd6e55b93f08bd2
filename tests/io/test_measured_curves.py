# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tables of measured load-extension curves: units, loading branches, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.measured_curves import FORM, MeasuredCurve, read_measured_curves, write_measured_curves


def written(folder: Path, text: str) -> Path:
    path = folder / "curve.csv"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    "text",
    [
        "direction,other,strain [%],load [N/m]\nwale,free,0,0\nwale,free,10,2\nwale,free,20,5\n",
        "# direction: wale\nstrain,tension (N/m)\n0,0\n0.1,2\n0.2,5\n",
        "# direction: wale\n# length: 10 cm\n# width: 50 mm\nExtension [mm], Force [cN]\n0,0\n10,10\n\n20,25\n",
        "# direction: Wale\nload [dyn/cm],strain [%]\n0,0\n2000,10\n5000,20\n",
    ],
)
def test_units_of_the_head_give_ratios_and_dynes_per_centimetre(tmp_path: Path, text: str) -> None:
    (curve,) = read_measured_curves(written(tmp_path, text))
    assert (curve.direction, curve.other) == ("wale", "free")
    np.testing.assert_allclose(curve.strain, [0.0, 0.1, 0.2], rtol=1e-12)  # rounding of the factors
    np.testing.assert_allclose(curve.tension, [0.0, 2000.0, 5000.0], rtol=1e-12)


def test_a_table_of_both_directions_gives_the_loading_branch_of_each(tmp_path: Path) -> None:
    rows = ["course,free,0,0", "course,free,10,1", "course,free,9.5,1", "course,free,20,2", "course,free,10,0.2",
            "wale,held,5,3", "wale,held,5,5"]  # fmt: skip
    text = "direction,other,strain [%],load [N/m]\n" + "\n".join(rows) + "\n"
    course, wale = read_measured_curves(written(tmp_path, text))
    np.testing.assert_allclose(course.strain, [0.0, 0.1, 0.2])
    np.testing.assert_allclose(course.tension, [0.0, 1000.0, 2000.0])
    assert (wale.direction, wale.other) == ("wale", "held")
    np.testing.assert_allclose(wale.tension, [4000.0])


def test_written_curves_are_read_again(tmp_path: Path) -> None:
    random = np.random.default_rng(0)
    curves = [MeasuredCurve("course", np.sort(random.random(9)), random.random(9), "held"),
              MeasuredCurve("wale", np.array([0.1]), np.array([3.0]))]  # fmt: skip
    write_measured_curves(tmp_path / "curves.csv", curves)
    for found, expected in zip(read_measured_curves(tmp_path / "curves.csv"), curves, strict=True):
        assert (found.direction, found.other) == (expected.direction, expected.other)
        np.testing.assert_allclose(found.strain, expected.strain, rtol=1e-14)  # percent and back
        np.testing.assert_allclose(found.tension, expected.tension, rtol=1e-14)


def test_many_rows_are_thinned_without_a_bias_of_a_bent_curve() -> None:
    strain = np.linspace(0.0, 0.4, 401)
    curve = MeasuredCurve("wale", strain, 100.0 * np.expm1(10.0 * strain)).thinned(8)
    np.testing.assert_allclose(curve.strain, np.linspace(0.05, 0.4, 8))
    # A parabola over two intervals of 0.5 of the length over which the curve grows e-fold misses it by 1 %.
    np.testing.assert_allclose(curve.tension, 100.0 * np.expm1(10.0 * curve.strain), rtol=0.015)


def test_thinning_leaves_few_rows_and_takes_out_the_free_state() -> None:
    curve = MeasuredCurve("wale", np.array([0.0, 0.1, 0.2]), np.array([0.0, 1.0, 2.0])).thinned(6)
    assert curve.strain.tolist() == [0.1, 0.2]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (f"{FORM}\n", "has no rows of numbers"),
        ("strain [%],load [N/m]\n1,2\n", "direction: got none"),
        ("direction,strain [%]\nwale,1\n", "head: got"),
        ("# direction: wale\nstrain,load\n1,2\n", "load: got no unit"),
        ("# direction: wale\nstrain,load [N]\n1,2\n", "width: got none for values in N"),
        ("# direction: wale\nextension [mm],load [N/m]\n1,2\n", "length: got none for values in mm"),
        ("# direction: wale\nextension,load [N/m]\n1,2\n", "extension: got no unit"),
        ("# direction: wale\nstrain [kg],load [N/m]\n1,2\n", "unit of strain: got '1 kg'"),
        ("# direction: up\nstrain,load [N/m]\n1,2\n", "got 'up'; expected course or wale"),
        ("direction,strain,load [N/m]\nwale,1,x\n", "line 2: got 'x'; expected a number"),
        ("direction,strain,load [N/m]\nwale,nan,1\n", "line 2: got 'nan'; expected a number"),
        ("direction,strain,load [N/m]\nwale,1\n", "line 2: got 2 cells"),
        ("direction,strain,load [N/m]\nwale,0,1\n", "got no strain above 0.0001"),
        ("direction,strain,load [N/m]\nwale,20,1\n", "got strains up to 20; expected ratios that rise, up to 9"),
        ("direction,strain,load [N/m]\nwale,0.2,-1\n", "got no positive tension"),
    ],
)
def test_a_wrong_table_is_refused_in_one_line(tmp_path: Path, text: str, expected: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(FileError) as caught:
        read_measured_curves(path)
    assert str(caught.value).startswith(f"{path}: ") and expected in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"direction": "up"}, "got 'up'"),
        ({"other": "loose"}, "got 'wale' with the other size 'loose'"),
        ({"strain": [0.2, 0.1]}, "ratios that rise"),
        ({"strain": [0.1]}, "got 1 strains and 2 tensions"),
        ({"tension": [1.0, np.inf]}, "no list of finite numbers"),
    ],
)
def test_a_wrong_curve_is_refused(given: dict, expected: str) -> None:
    usual = {"direction": "wale", "strain": [0.1, 0.2], "tension": [1.0, 2.0]}
    with pytest.raises(ParameterError, match=expected):
        MeasuredCurve(**(usual | given))
