# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Small pictures of stitches and patterns, which need no graphics library, and of states of rest side by side."""
