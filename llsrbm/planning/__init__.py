"""From a request to a `Plan`: variables, constraints, costs, transcription and solvers."""
