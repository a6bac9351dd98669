"""A JACK client of our own, whose callbacks are compiled."""
