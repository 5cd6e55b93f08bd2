# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Time that a command or a job needs after its relaxations, on a machine that has nothing else to do."""

from __future__ import annotations

FILES = 1.5
"""Time to write the files and to plot the convergence [s]."""
START_OF_RENDERER, POINT_OF_PICTURE = 2.0, 6e-5
"""Time to start the renderer and to plot the convergence [s], and to draw one control point without a GPU [s]."""
