"""From a task to an attempt: guesses, solvers kept in the cache, one solve."""
