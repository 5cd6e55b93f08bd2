# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knitting patterns as images: charts of yarn colours and of tile codes."""
