"""``python -m ukrt`` is the command ``ukrt``."""

from ukrt.cli.main import run

run()
