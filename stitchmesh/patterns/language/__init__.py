# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The text language of knitting patterns: reading a pattern from text and writing a pattern as text."""
