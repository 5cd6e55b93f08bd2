# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Budgets of time and of error, and the quality that measured tables give for them."""
