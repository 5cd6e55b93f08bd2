# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command line: commands that read files, run a stage and write files; each option is a field of a dataclass."""
