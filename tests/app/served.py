"""A server with made-up plans, to be killed: `python -m tests.app.served PORT`."""

import sys
import threading

from app.designer import Designer
from tests.app.planners import SyntheticPlanner

if __name__ == "__main__":
    running = Designer(port=int(sys.argv[1]), token="none", planner=SyntheticPlanner)
    print(running.port, flush=True)
    threading.Event().wait()
