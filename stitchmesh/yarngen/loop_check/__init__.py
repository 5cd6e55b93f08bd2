# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The loop check: whether the loops of yarns still hold each other as the stitches define."""
