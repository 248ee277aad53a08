"""From a request to a plan: guesses, attempts, solvers kept in the cache."""
