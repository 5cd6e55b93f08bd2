# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The application in the browser: pages over the functions that the command line uses too."""
