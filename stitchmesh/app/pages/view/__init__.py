# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page View: any file that the program writes, results of the project, and the folder of a job that runs."""
