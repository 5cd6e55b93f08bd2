# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tests of linking numbers and of yarn that passes through yarn."""
