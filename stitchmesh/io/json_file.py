# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""JSON files, of which damaged ones cost one error of a line."""

from __future__ import annotations

from os import fspath

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.checked import parse_json
from stitchmesh.io.contents import FilePath, read_bytes


def read_json(path: FilePath) -> object:
    """Read the value of a JSON file.

    Raises:
        FileError: the file cannot be read, is no text in UTF-8 or no JSON, or is nested more than
            ``checked.DEEPEST`` times.
    """
    content = read_bytes(path)
    try:
        return parse_json(content.decode("utf-8"))
    except UnicodeDecodeError as error:
        raise FileError(f"{fspath(path)}: is no text in UTF-8 ({error.reason} at byte {error.start})") from error
    except ParameterError as error:
        raise FileError(f"{fspath(path)}: {error}") from error
