# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""States of rest of a swatch: starts at random, and which of the states that they reach are the same."""
