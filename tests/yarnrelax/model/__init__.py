# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tests of the model: the constants and the state of the yarns on the device."""
