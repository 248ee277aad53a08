"""Plans judged by the whole robot: loads and margins of the joints, realised momenta."""
