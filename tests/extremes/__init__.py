# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Extreme yarns, swatches and cloths: each ends finite and valid, or with one line of error."""
