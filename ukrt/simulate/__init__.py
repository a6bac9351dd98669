"""Either solver runs a case: `simulate(case, solver)` gives a `Result`, whichever it is."""
