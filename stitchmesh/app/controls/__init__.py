# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The controls of a panel: buttons, numbers, choices, texts and plots, and their places."""
