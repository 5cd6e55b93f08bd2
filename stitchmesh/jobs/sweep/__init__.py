# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sweeps: many jobs that differ in some options, run by processes on one machine or on several machines."""
