# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sewing patterns: panels that are knitted one by one in given directions, and joined at their seams."""
