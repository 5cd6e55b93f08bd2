# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The history of a relaxation as a plot and as a table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.history import HistoryEntry
from stitchmesh.render.plots.convergence_plot import plot_convergence
from stitchmesh.yarn.colours import DYES


def history(count: int = 40, *, shape: bool = True) -> list[HistoryEntry]:
    """A residual that decreases geometrically, and energies that converge."""
    entries: list[HistoryEntry] = []
    for k in range(count):
        energies = {"stretch": 300.0 * 0.9**k + 8.0, "bend": 900.0 - k / 3, "contact": 4000.0 * 0.8**k + 150.0}
        if shape and k:
            energies["shape"] = 30.0 * (1 - 0.9**k)
        entries.append({"iteration": 20 * k, "seconds": 0.07 * k**2, "residual": 0.9 * 0.87**k, "energies": energies})
    return entries


def pixels(path: Path) -> np.ndarray:
    return np.asarray(Image.open(path).convert("RGB")).astype(int)


def has_colour(path: Path, colour: np.ndarray) -> bool:
    """Whether the number of pixels of a colour is large enough for a curve."""
    near = np.abs(pixels(path) - np.round(255 * colour)).max(axis=2) <= 2  # Rounding of the colour.
    return int(near.sum()) > 200


@pytest.fixture(scope="module")
def picture(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("plot") / "run" / "convergence.png"
    plot_convergence(history(), path, tolerance=0.005)
    return path


def test_the_plot_is_drawn_and_no_other_file_is_left(picture):
    assert [path.name for path in picture.parent.iterdir()] == ["convergence.png"]
    image = pixels(picture)
    assert image.shape == (900, 1200, 3)
    assert (image == 255).all(axis=2).mean() > 0.5  # Most of the plot is white.


def test_each_energy_term_is_drawn_as_a_curve_and_the_tolerance_as_a_line(picture, tmp_path):
    plot_convergence(history(shape=False), tmp_path / "less.png", tolerance=0.005)
    plot_convergence(history(shape=False), tmp_path / "without.png")
    assert all(has_colour(picture, colour) for colour in DYES[:4])
    assert all(has_colour(tmp_path / "less.png", colour) for colour in DYES[:3])
    assert not has_colour(tmp_path / "less.png", DYES[3])
    assert (pixels(tmp_path / "less.png") != pixels(tmp_path / "without.png")).any()


@pytest.mark.parametrize(
    ("count", "residual", "energies"),
    [
        (1, 0.3, {}),
        (2, 0.0, {"bend": 0.0}),
        (2, float("nan"), {"bend": 1.0, "contact": float("inf")}),
    ],
)
@pytest.mark.filterwarnings("error")
def test_histories_with_few_entries_or_special_values_are_drawn(tmp_path, count, residual, energies):
    entry: HistoryEntry = {"iteration": 0, "seconds": 0.0, "residual": residual, "energies": energies}
    plot_convergence([entry] * count, tmp_path / "plot.png", tolerance=0.01)
    assert (tmp_path / "plot.png").exists()


def test_what_cannot_be_drawn_or_written_is_refused(tmp_path):
    with pytest.raises(ParameterError, match="history: got no entries; expected at least one"):
        plot_convergence([], tmp_path / "plot.png")
    assert not list(tmp_path.iterdir())
    (tmp_path / "plot.png").mkdir()
    with pytest.raises(FileError, match="is a folder"):
        plot_convergence(history(), tmp_path / "plot.png")
