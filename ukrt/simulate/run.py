"""One call for both solvers: a case and a solver's name enter, a result leaves."""

from ..errors import ParameterError

SOLVERS = ("reference", "engine")


def simulate(case, solver="reference", progress=None):
    """Run a case.

    Parameters
    ----------
    case : ukrt.experiment.case.Case
    solver : {"reference", "engine"}
        The paper's scheme, or the real-time engine's compiled loop at ``case.sample_rate``.
    progress : callable, optional
        Called now and then with the share that is done, 0 to 1.

    Returns
    -------
    ukrt.experiment.result.Result
        The same quantities in the same order from either; times differ by the solver's step.

    Raises
    ------
    ParameterError
        What the solver cannot do, such as a step too long or two plucks at once on one string (engine).
    """
    if solver not in SOLVERS:
        raise ParameterError("solver", solver, f"it must be one of {', '.join(SOLVERS)}")
    if solver == "reference":
        from ..reference.solver import simulate as run
    else:
        from .on_engine import simulate as run
    return run(case, progress=progress)
