"""A `Comparison` as plain numbers for JSON."""


def as_record(result):
    """Everything in it: dict of str, int and lists of float."""
    note, scheme = result.note, result.scheme
    record = {
        "solver": scheme.solver,
        ("sample_rate" if scheme.solver == "engine" else "step_s"): scheme.rate
        if scheme.solver == "engine"
        else scheme.step,
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
    if scheme.solver == "reference":
        record["nearest"] = dict(zip(("cents", "decay_errors"), (part.tolist() for part in result.nearest), strict=True))
        record["cut_cents"] = result.cut_cents.tolist()
        record["beyond_theory"] = dict(zip(("cents", "decay_errors"), (p.tolist() for p in result.own), strict=True))
    return record
