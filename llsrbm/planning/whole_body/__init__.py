"""The second stage: a centroidal plan made one of the whole body's equations of motion."""
