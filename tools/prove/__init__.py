"""Parts of ``tools/prove_live.py``: one file for each proof, and what they share."""
