"""The work of a run: listing, scheduling, workers."""
