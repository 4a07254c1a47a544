"""Where a fixed camera is: from points of the floor, from taped lengths, from what is known of it, or from people."""
