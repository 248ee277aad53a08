"""One tab: its state, how events change it, and what that has done outside of it."""
