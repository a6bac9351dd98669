"""The paper's scheme in NumPy; see `peers.paper_numpy`."""

import numpy

from .peer import Peer, Ready, worker

SECONDS = (1.0, 4.0)  # slow: a minute of it would take minutes


def _prepare(_work):
    return Ready(lambda seconds, target: worker("paper_numpy", seconds, target), f"NumPy {numpy.__version__}", SECONDS)


PEERS = (Peer("the paper's scheme in NumPy", "764 coupled modes, linear, factored projection, 1e-5 s", (), _prepare),)
