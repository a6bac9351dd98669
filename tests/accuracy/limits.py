"""What the project demands of the engine's poles: a number of contacts and a partial enter, bounds leave."""


def limits(n_contacts, partial):
    """What the project demands: cents and relative decay rate; None where it demands nothing."""
    if n_contacts > 3:
        return None
    if n_contacts > 1:
        return (0.3, 0.06) if partial <= 5 else None
    return (0.05 if partial <= 5 else 0.3), 0.01


def broken_limits(result):
    """The limits that a `Comparison` breaks, in words: list of str, empty if all is well."""
    words = []
    for n, cents, loss in zip(result.partials, result.cents, result.decay_errors, strict=True):
        allowed = limits(result.note.n_contacts, n)
        if allowed and not abs(cents) <= allowed[0]:
            words.append(f"{result.note}, partial {n}: {cents:+.3f} cents, legal {allowed[0]:g}")
        if allowed and not abs(loss) <= allowed[1]:
            words.append(f"{result.note}, partial {n}: decay {100 * loss:+.2f} %, legal {100 * allowed[1]:g} %")
    return words
