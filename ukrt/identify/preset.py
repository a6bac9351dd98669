"""An identified body as a whole preset: TOML text that `load_preset` reads, with where it comes from on top."""

import dataclasses

from ..model.preset_text import dump_preset


def preset_of(found, guitar, name, measurement):
    """A preset with an identified body.

    Parameters
    ----------
    found : ukrt.identify.Identification
    guitar : ukrt.model.parameters.Guitar
        Everything but the body.
    name : str
        Of the new preset.
    measurement : ukrt.identify.Measurement

    Returns
    -------
    str
        TOML; the same for the same measurement.

    Raises
    ------
    MeasurementError
        A mode is beyond what a body may have.
    """
    words = f"{guitar.name} with a body identified from measurements: {len(found.frequencies_hz)} modes"
    made = dataclasses.replace(guitar, name=name, description=words, body=found.body())
    return "".join(f"# {line}\n" for line in _provenance(found, guitar, measurement)) + "\n" + dump_preset(made)


def _provenance(found, guitar, measurement):
    """Lines of comment (list of str)."""
    low, high = found.band.frequencies[[0, -1]]
    lines = [
        f"The guitar of the preset {guitar.name} with a body identified by `ukrt identify` from impulse responses",
        f"({measurement.quantity}, {measurement.seconds:.3g} s at {measurement.sample_rate:.6g} Hz):",
        *(f"  {_one_line(source)}" for source in measurement.sources),
        f"Eigensystem Realization Algorithm, {len(found.frequencies_hz)} modes from {low:.0f} to {high:.0f} Hz. Of",
        "the response in this band these modes alone leave unexplained:",
        *(f"  {path:<14} {db:.1f} dB" for path, db in found.fits.items()),
        *(f"Note: {note}." for note in found.notes),
    ]
    lines.append("Standard uncertainties (spread over model orders, noise):")
    for name, values in found.uncertainties.items():
        columns = zip(("_bass", "_treble"), values.T, strict=True) if values.ndim == 2 else (("", values),)
        lines += [f"  {name + end:<14} {', '.join(f'{value:.1g}' for value in column)}" for end, column in columns]
    return lines


def _one_line(text):
    """A file's name without what a comment cannot hold."""
    return "".join(letter if letter.isprintable() else "?" for letter in text)
