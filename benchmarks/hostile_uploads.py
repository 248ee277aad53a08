"""Damaged files against what a tab opens: `python -m benchmarks.hostile_uploads [--files 10000]`.

Every file is opened as the page's computing processes open it, and has to end in something that can
be shown or in one line that says why not. Anything else is a defect, and the exit status is then 1.
"""

from __future__ import annotations

import argparse
import re
import resource
import sys
import time
import traceback
from collections import Counter

from app.workers.file_reading import UNFORESEEN, open_file
from llsrbm.errors import Error
from tests.app.damaged import Damaged

LONGEST_LINE = 1000  # characters
PATIENCE = 2.0  # s


def main() -> int:
    """Open the files and print how they ended."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--files", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0, help="seed of the first file")
    given = parser.parse_args()
    files = Damaged()
    ended, why, seconds, defects = Counter(), Counter(), [], []
    unforeseen = 0
    for seed in range(given.first, given.first + given.files):
        name, content = files.damaged(seed)
        start = time.perf_counter()
        try:
            opened = open_file(name, content, "anymal", 30.0)
            ended[f"shown: {type(opened.holds).__name__}"] += 1
        except Error as error:
            ended["refused"] += 1
            line = str(error)
            if UNFORESEEN in line:
                unforeseen += 1
                print(f"seed {seed}: {line}")
            why[re.sub(r"[0-9.]+|\"[^\"]*\"|'[^']*'", "*", line.partition(": ")[2])[:60]] += 1
            if "\n" in line or len(line) > LONGEST_LINE or "/tmp/" in line:
                defects.append((seed, name, f"line: {line[:200]!r}"))
        except Exception:  # noqa: BLE001  # what it looks for
            defects.append((seed, name, traceback.format_exc(limit=-3)))
        seconds.append(time.perf_counter() - start)
        if seconds[-1] > PATIENCE:
            defects.append((seed, name, f"took {seconds[-1]:.1f} s"))
    for seed, name, what in defects[:20]:
        print(f"seed {seed} ({name}): {what}")
    print(f"{given.files} files: " + ", ".join(f"{n} {how}" for how, n in ended.most_common()))
    for line, count in why.most_common(25):
        print(f"  {count:6d}  {line}")
    seconds.sort()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"median {1e3 * seconds[len(seconds) // 2]:.0f} ms, longest {seconds[-1]:.2f} s")
    print(f"peak memory {peak:.0f} MB")
    print(f"{unforeseen} refused by the last guard alone, {len(defects)} defects")
    return 1 if defects else 0


if __name__ == "__main__":
    sys.exit(main())
