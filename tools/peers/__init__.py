"""Peers of ukrt and ukrt itself, timed on one and the same piece: the parts of ``tools/bench_peers``."""
