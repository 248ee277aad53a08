"""This project's own files: plans and simulations as npz without pickle."""
