# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Charts of knits and weaves: how they are edited, written and drawn."""
