"""A folder for MuJoCo, and motions in its coordinates."""
