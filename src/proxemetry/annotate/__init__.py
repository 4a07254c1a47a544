"""A person's own photos as a benchmark: points clicked, places taped, the three label files, and the score on them."""
