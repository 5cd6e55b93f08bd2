# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How a repeat comes to rest: its preparation, its support, its way off the needles, and the lowest of its states."""
