"""How many processes it is worth to start."""

import os
import subprocess
import sys

import pytest

CODE = """
import os
os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
from app.workers.pool import PROCESSES
from llsrbm.processors import usable_processors
print(usable_processors(), PROCESSES)
"""


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="no affinity on this system")
def test_a_process_counts_the_processors_that_it_may_use():
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["1", "2"]
