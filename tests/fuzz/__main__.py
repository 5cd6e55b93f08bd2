# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Readers of files on damaged files: each must return a value or raise one error of a line.

    python -m tests.fuzz --inputs 100000 --processes 8         # all readers
    python -m tests.fuzz --seconds 20 --inputs 1000000         # all readers, each for 20 s at most
    python -m tests.fuzz usda ply --inputs 1000 --seed 7       # two readers, other damage
    python -m tests.fuzz ply --show 4711 > damaged.ply         # the file of one input

Faults are: another exception, an end of the process, more processor time than 10 s for a file, and more memory than
128 MiB and 500 bytes for each byte of the file. Each kind of fault is a line, and its smallest file is kept in the
folder of the output. The last table is that of docs/robustness.md.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import time
from pathlib import Path

os.environ |= {"PXR_WORK_THREAD_LIMIT": "1", "MALLOC_ARENA_MAX": "1", "OPENBLAS_NUM_THREADS": "1"}

from tests.fuzz.readers import READERS
from tests.fuzz.run import Findings, damaged, fuzz, keep_findings, seeds_of


def main() -> int:
    """Read damaged files; the status is 1 if there are faults."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("readers", nargs="*", help=f"readers (default all): {', '.join(READERS)}")
    parser.add_argument("--inputs", type=int, default=1000, help="damaged files for each reader")
    parser.add_argument("--seconds", type=float, default=math.inf, help="time for each reader, after which it ends")
    parser.add_argument("--processes", type=int, default=1, help="workers")
    parser.add_argument("--seed", type=int, default=0, help="seed of the damage")
    parser.add_argument("--show", type=int, help="print the damaged file of this number")
    parser.add_argument("-o", "--output", type=Path, default=Path("out/fuzz"), help="folder of the smallest files")
    arguments = parser.parse_args()
    names = arguments.readers or list(READERS)
    if arguments.show is not None:
        _show(names[0], arguments.seed, arguments.show)
        return 0
    found = [_run(name, arguments) for name in names]
    print("\n" + "\n".join(table(found)))
    return int(any(one.faults for one in found))


def table(found: list[Findings]) -> list[str]:
    """Return the lines of a table: inputs, values and errors of each reader."""
    lines = ["| reader | inputs | values | errors | faults |", "|---|---|---|---|---|"]
    for one in found:
        errors = [f"{count:,} `{name}`" for name, count in one.outcomes.most_common() if name not in ("value", "fault")]
        values, faults = one.outcomes["value"], one.outcomes["fault"]
        lines.append(f"| {one.reader} | {one.inputs:,} | {values:,} | {', '.join(errors)} | {faults:,} |")
    return lines


def _run(name: str, arguments: argparse.Namespace) -> Findings:
    start = time.monotonic()

    def report(found: Findings) -> None:
        if sys.stderr.isatty():
            print(f"\r{name}: {found.inputs} of {arguments.inputs}", end="", file=sys.stderr, flush=True)

    found = fuzz(
        name, arguments.inputs, seconds=arguments.seconds, seed=arguments.seed, processes=arguments.processes,
        report=report,
    )  # fmt: skip
    print(f"\r{name}: {found.inputs} inputs in {time.monotonic() - start:.1f} s", file=sys.stderr)
    for line in keep_findings(arguments.output, found, arguments.seed):
        print(line, flush=True)
    return found


def _show(name: str, seed: int, number: int) -> None:
    reader = READERS[name]
    sys.stdout.buffer.write(damaged(reader, seeds_of(reader), seed, number))


if __name__ == "__main__":
    sys.exit(main())
