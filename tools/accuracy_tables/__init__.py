"""Rooms of tools/pole_table.py and tools/convergence_table.py. Import with the checkout and its ``tests`` on the path."""
