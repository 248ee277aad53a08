"""Reference motions, as trainers and retargeters read them."""
