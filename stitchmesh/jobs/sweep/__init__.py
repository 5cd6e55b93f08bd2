# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sweeps: many jobs that differ in some options, on the processes of one machine or of several."""
