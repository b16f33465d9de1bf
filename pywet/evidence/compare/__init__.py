"""Two finished runs, or two groups of runs that differ in the seed, against each other; and against a stored digest."""
