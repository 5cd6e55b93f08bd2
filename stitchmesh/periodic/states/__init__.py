# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""States of rest of a swatch: which states random starts reach, and which of these are the same."""
