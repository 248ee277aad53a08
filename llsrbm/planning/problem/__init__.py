"""The optimal control problem of a jump: variables, constraints, costs."""
