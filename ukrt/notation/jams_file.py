"""Annotations as JAMS (Humphrey et al., ISMIR 2014), laid out as in GuitarSet (Xi et al., ISMIR 2018).

A ``note_midi`` annotation for each string, whose ``data_source`` is the string's number, 0 the lowest: time, duration
and MIDI pitch of each note, exactly as played. ``beat_position`` and ``tempo`` follow from the bars. What the
namespaces have no field for, frets and articulations, stands in each annotation's sandbox, in the order of its notes.

JAMS is JSON; it is written here by ``json`` alone, since the package ``jams`` brings pandas, SciPy and mir_eval along.
"""

import json

from ukrt.notation.names import note_name

JAMS_VERSION = "0.3.4"  # whose schema this is


def make_jams(sheet, score, software):
    """The text of a JAMS file (str).

    Parameters
    ----------
    sheet : Sheet
    score : Score
        Of the whole piece; notes that ring when it ends, end there.
    software : str
    """
    duration_s = score.duration_s
    strings = range(len(sheet.open_keys))
    annotations = [_string(sheet, string, software, duration_s) for string in strings]
    annotations += [_beats(sheet, score.bars, software, duration_s), _tempo(sheet, software, duration_s)]
    tree = {
        "file_metadata": {
            "title": sheet.title,
            "artist": "",
            "release": "",
            "duration": duration_s,
            "identifiers": {},
            "jams_version": JAMS_VERSION,
        },
        "annotations": annotations,
        "sandbox": {"guitar": sheet.guitar, "open_strings": sheet.open_keys},
    }
    return json.dumps(tree, indent=1) + "\n"


def _annotation(namespace, data, source, software, duration_s, sandbox):
    metadata = {
        "curator": {"name": "", "email": ""},
        "annotator": {},
        "version": "",
        "corpus": "",
        "annotation_tools": software,
        "annotation_rules": "string and fret as played by the program's guitarist",
        "validation": "",
        "data_source": source,
    }
    return {
        "annotation_metadata": metadata,
        "namespace": namespace,
        "data": data,
        "sandbox": sandbox,
        "time": 0.0,
        "duration": duration_s,
    }


def _observation(time, duration, value, confidence=None):
    return {"time": time, "duration": duration, "value": value, "confidence": confidence}


def _string(sheet, string, software, duration_s):
    """The notes of one string."""
    tones = [tone for tone in sheet.tones if tone.string == string]
    ends = [tone.end_s if tone.end_s is not None else max(duration_s, tone.start_s) for tone in tones]
    for k, following in enumerate(tones[1:]):
        ends[k] = min(ends[k], following.start_s)  # no string has two notes
    data = [
        _observation(tone.start_s, max(end - tone.start_s, 0.0), float(tone.pitch))
        for tone, end in zip(tones, ends, strict=True)
    ]
    sandbox = {
        "open_string": sheet.open_keys[string],
        "name": note_name(sheet.open_keys[string]),
        "frets": [tone.fret for tone in tones],
        "articulations": [tone.articulation for tone in tones],
    }
    return _annotation("note_midi", data, str(string), software, duration_s, sandbox)


def _beats(sheet, bars, software, duration_s):
    data = []
    for bar in (measure.bar for measure in sheet.measures):
        for beat in range(1, bar.numerator + 1):
            if (seconds := bars.seconds(bar.number, beat)) is not None:  # None: the bar is cut short before
                value = {"position": beat, "measure": bar.number, "num_beats": bar.numerator}
                data.append(_observation(seconds, 0.0, value | {"beat_units": bar.denominator}))
    return _annotation("beat_position", data, "", software, duration_s, {})


def _tempo(sheet, software, duration_s):
    """The tempo at the beginning of each bar, where it changes."""
    changes = []
    for measure in sheet.measures:
        if not changes or measure.bar.quarter_us != changes[-1].quarter_us:
            changes.append(measure.bar)
    ends = [bar.start_s for bar in changes[1:]] + [duration_s]
    data = [
        _observation(bar.start_s, max(end - bar.start_s, 0.0), 60e6 / bar.quarter_us, 1.0)
        for bar, end in zip(changes, ends, strict=True)
    ]
    return _annotation("tempo", data, "", software, duration_s, {})
