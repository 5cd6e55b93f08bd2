# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Friction of yarns that slide through crossings, and the normal forces that hold them."""
