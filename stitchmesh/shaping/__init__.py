# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rows and stitches on any surface: a time function, its level lines as courses, and stitches between them."""
