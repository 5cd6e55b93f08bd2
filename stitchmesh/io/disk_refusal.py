# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages that say why the operating system refuses to write a file, and what the user can do."""

from __future__ import annotations

import errno
import os

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Numbers of the errors that say that a disk, a share of a disk or a file cannot become larger."""
SPACE = "free space on this disk, or choose a folder on another one"
FORBIDDEN = "choose a folder that you may write"
REMEDIES = {
    None: "the disk may be full: free space on it, or choose another folder",
    errno.ENOSPC: SPACE,
    errno.EDQUOT: SPACE,
    errno.EFBIG: "the largest size of a file is limited here (`ulimit -f`); raise it, or choose another disk",
    errno.ENOENT: "its folder was removed meanwhile; begin again",
    errno.EACCES: FORBIDDEN,
    errno.EPERM: FORBIDDEN,
    errno.EROFS: FORBIDDEN,
}
"""The remedy for the user, by the number of the error; a write that was cut short has no number."""


def refusal(error: OSError) -> str:
    """Return the reason in brackets and the remedy, for a message about a file or a folder."""
    return f"({error.strerror or error}); {REMEDIES.get(error.errno, 'choose another folder')}"


def as_refusal(reason: str) -> OSError:
    """Turn the text of a library's error, which quotes an error of the operating system, into such an error."""
    quoted = (number for number in REMEDIES if number is not None and os.strerror(number) in reason)
    return OSError(next(quoted, errno.EIO), reason)
