"""The whole robot in MuJoCo, following a plan."""
