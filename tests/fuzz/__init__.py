# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Damaged files for all readers: some in every run of the tests, very many with ``make test-nightly``."""
