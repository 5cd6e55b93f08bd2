# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenes of mixed yarns and triangles: cloth, yarns, region, attachments, bodies and motion, in one file."""
