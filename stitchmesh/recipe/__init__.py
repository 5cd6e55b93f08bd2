# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Recipes: a garment with its patterns, edits and colours in one file."""
