"""From a request to its plan, or to a refusal by what stops it with the nearest jump.

`planner.planner_of` is the entrance: other rooms import `planner` alone.
"""
