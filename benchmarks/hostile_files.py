"""Damaged and hostile files: `python -m benchmarks.hostile_files --count 10000 --seed 1`.

Each file is made from a sound plan or rollout by one kind of damage (tests/llsrbm/hostile.py) and
opened with `llsrbm.load`, designs with `llsrbm.load_design`. It has to be refused in one line, or
to open; what opens is summarised, described and exported. Anything else is printed with its number,
which `--only` repeats, and the exit status is 1.
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path

import numpy as np

from tests.llsrbm.hostile import DAMAGE, SOUND, Seeds, damaged_design, outcome, outcome_of_design

SLOW = 2.0  # s a file


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, help="the number of one file, to look at")
    arguments = parser.parse_args()
    counts, failures, slowest = Counter(), 0, (0.0, "")
    with tempfile.TemporaryDirectory() as folder:
        seeds, path = Seeds(Path(folder)), Path(folder) / "damaged.npz"
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        kinds = [*DAMAGE, "designs"]
        for number in range(arguments.count) if arguments.only is None else [arguments.only]:
            kind = kinds[number % len(kinds)]
            rng = np.random.default_rng([arguments.seed, number])
            content = damaged_design(rng) if kind == "designs" else DAMAGE[kind](seeds, rng)
            path.write_bytes(content)
            began = time.perf_counter()
            try:
                if kind == "designs":
                    word = outcome_of_design(content)
                else:
                    word = outcome(path, seeds.canary, Path(folder))
            except BaseException as error:  # what it looks for
                if isinstance(error, KeyboardInterrupt):
                    raise
                word = f"TRACEBACK {type(error).__name__}"
                print(f"file {number} ({kind}):\n{traceback.format_exc()}", file=sys.stderr)
            took = time.perf_counter() - began
            slowest = max(slowest, (took, f"file {number} ({kind})"))
            if took > SLOW:
                word = f"{word}, slowly"
            if word not in SOUND:
                failures += 1
                print(f"file {number} ({kind}): {word}")
            counts[kind, word[:40]] += 1
        after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for (kind, word), count in sorted(counts.items()):
        print(f"{kind:18} {word:40} {count}")
    total = Counter()
    for (_, word), count in counts.items():
        total[word] += count
    print(f"{sum(total.values())} files of seed {arguments.seed}: {dict(total)}")
    print(f"slowest {slowest[0]:.2f} s, {slowest[1]}; peak memory +{(after - before) // 1024} MB")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
