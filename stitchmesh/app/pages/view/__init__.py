# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page View: any file of the program, results of the project, and the folder of a running job."""
