"""A session that goes on whatever happens to its devices, and the player of pieces."""
