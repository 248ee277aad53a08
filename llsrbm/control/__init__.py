"""Following a plan with the whole body: tasks, one quadratic program a tick, contact detection."""
