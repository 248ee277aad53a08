"""What a jump is to be: the jump, its schedule, tuning, scenario and pushes, and design files."""
