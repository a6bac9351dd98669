"""What a figure runs its cases by: a case enters, a result leaves, and progress is told on the way."""

from ..simulate.run import simulate


class Run:
    """Runs cases by one solver.

    Parameters
    ----------
    solver : {"reference", "engine"}
    progress : callable, optional
        Called with the case's name and the share of it that is done, 0 to 1.

    Attributes
    ----------
    solver : str
    """

    def __init__(self, solver="reference", progress=None):
        self.solver, self._progress = solver, progress

    def __call__(self, case):
        """Run a case: `ukrt.experiment.result.Result`."""
        tell = self._progress
        return simulate(case, self.solver, progress=tell and (lambda share: tell(case.name, share)))
