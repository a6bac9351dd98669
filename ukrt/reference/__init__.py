"""The paper's own scheme: Udwadia-Kalaba accelerations and velocity-Verlet, to check the engine against.

It shares parameters, modes and constraint rows with the engine, and nothing else."""
