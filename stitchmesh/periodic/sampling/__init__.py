# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How finely the yarns of a repeat are sampled, and in how many places contact is measured."""
