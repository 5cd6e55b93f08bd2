# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits of a stitch mesh: each edit is data (a name and arguments) and has an exact inverse."""
