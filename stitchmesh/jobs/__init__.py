# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Jobs: runs from one file, whose finished stages are kept and which continue where they were stopped."""
