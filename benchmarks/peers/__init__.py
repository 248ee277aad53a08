"""Other planners on the same tasks, judged by one checker: `make peers`."""
