# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Commands that are killed while they write, and disks that refuse their files."""
