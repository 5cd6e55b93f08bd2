# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One repeat of a pattern: its mesh, its checks, its smallest cell and its yarns before any relaxation."""
