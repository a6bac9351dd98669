"""A `Comparison` as plain numbers for JSON."""


def as_record(result):
    """Everything in it: dict of str, int and lists of float."""
    note, scheme = result.note, result.scheme
    record = {
        "solver": scheme.solver,
        "step_s": 1.0 / scheme.rate if scheme.solver == "engine" else scheme.step,
        "basis_hz": scheme.basis_hz,
        "string": note.string,
        "fret": note.fret,
        "contacts": note.n_contacts,
        "polarization": note.polarization,
        "partials": list(result.partials),
        "frequencies_hz": result.frequencies_hz.tolist(),
        "decay_rates": result.decay_rates.tolist(),
        "cents": result.cents.tolist(),
        "decay_errors": result.decay_errors.tolist(),
    }
    for name, (cents, decay_errors) in vars(result.theory).items() if result.theory else ():
        record[f"theory_{name}"] = {"cents": cents.tolist(), "decay_errors": decay_errors.tolist()}
    return record
