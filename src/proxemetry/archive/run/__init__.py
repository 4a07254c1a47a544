"""Who does the work of a run: listing, scheduling, workers."""
