# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Measurements: ``scenes`` are what is measured, ``measures`` how, and ``run.py`` runs them."""
