# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The report of a run of mixed yarns and triangles as a table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stitchmesh.app.controls.html_pieces import figures
from stitchmesh.markup import Markup


def report_html(report: Mapping[str, Any]) -> Markup:
    """Return the numbers of a report; an empty text for a report without an entry ``mixed``."""
    mixed = report.get("mixed")
    if not isinstance(mixed, dict):
        return Markup()
    unit = "dyn" if mixed.get("mode") == "static" else "cm/s"
    rows = [
        ("Converged", "yes" if mixed.get("converged") else "no"),
        ("Error", f"{_number(mixed, 'error'):.2g} {unit}"),
        ("Steps", f"{_number(mixed, 'steps'):,.0f}"),
        ("Time of a step", f"{_number(mixed, 'seconds_per_step'):.3g} s"),
        ("Newton iterations", f"{_number(mixed, 'newton_iterations'):,.0f}"),
        ("Products with the matrix", f"{_number(mixed, 'solve_iterations'):,.0f}"),
        ("Largest memory", f"{1e-6 * _number(mixed, 'memory_bytes'):,.0f} MB"),
        ("Energy", f"{_number(mixed, 'energy'):.4g} erg"),
    ]
    energies = mixed.get("energies")
    if isinstance(energies, dict):
        rows += [(f"of {name}", f"{_number(energies, name):.4g} erg") for name in energies]
    return figures(rows, "Report")


def _number(table: Mapping[str, Any], name: str) -> float:
    """A number of a table; 0 if the table has none of this name."""
    value = table.get(name)
    return float(value) if isinstance(value, int | float) else 0.0
