# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The swatch book: every pattern of the library at rest, as pages that open from a folder."""
