"""Rooms of tools/pole_table.py and convergence_table.py. Import with the checkout and its ``tests`` on the path."""
