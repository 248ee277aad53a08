"""The designer: a page in the browser where a jump is asked for, planned and looked at."""
