# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Defaults of yarns that follow a moving body, which the command line shows without loading Warp."""

DRAG = 10.0
"""Drag of the air [1 / s]: a free fall then ends at 98 cm/s."""
MOST_DRAG = 1e5
"""Largest drag [1 / s]. Time steps are at most as long as its inverse, so a larger drag would only cost time."""
BODY_FRICTION = 0.3
"""Coefficient of friction with the body."""
