"""Numerical experiments as data: what is there, what is done to it and what is recorded (`case`), and what came out
(`result`). Either solver, the engine or the reference, runs a case; neither is known here."""
