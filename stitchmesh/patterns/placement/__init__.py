# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Patterns laid on a stitch mesh: where their tiles lie, and which faces change."""
