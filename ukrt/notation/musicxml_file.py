"""Tablature as MusicXML 4.0: a sheet enters, the text of a score with one tablature staff leaves.

Each note has its sounding pitch, string (1 the highest, as MusicXML counts) and fret. Strings ring on, so a note or
chord is written as long as one note value can be before the next one begins, and rests fill what is left. The library
``musicxml`` is made from the format's schema and refuses what that forbids.
"""

import musicxml.xmlelement.xmlelement as xml

from ukrt.notation.names import spell

DIVISIONS = 48  # of a quarter note: all parts that a sheet has are whole numbers of these
# Duration -> (type, dots, whether three stand for two); dotted 64ths and the like are not written.
_TYPES = {192: "whole", 96: "half", 48: "quarter", 24: "eighth", 12: "16th", 6: "32nd", 3: "64th"}
_VALUES = (
    {length: (name, 0, False) for length, name in _TYPES.items()}
    | {length * 3 // 2: (name, 1, False) for length, name in _TYPES.items() if length > 3}
    | {length * 2 // 3: (name, 0, True) for length, name in _TYPES.items() if 3 < length < 192}
)
_LINES = {"hammer-on": (xml.XMLHammerOn, "H"), "pull-off": (xml.XMLPullOff, "P")}


def make_musicxml(sheet, software):
    """The text of a MusicXML file (str).

    Parameters
    ----------
    sheet : Sheet
    software : str
        Named as what made the file.
    """
    score = xml.XMLScorePartwise(version="4.0")
    if sheet.title:
        score.add_child(xml.XMLWork()).add_child(xml.XMLWorkTitle(sheet.title))
    score.add_child(xml.XMLIdentification()).add_child(xml.XMLEncoding()).add_child(xml.XMLSoftware(software))
    score_part = score.add_child(xml.XMLPartList()).add_child(xml.XMLScorePart(id="P1"))
    score_part.add_child(xml.XMLPartName(f"Guitar ({sheet.guitar})"))
    part = score.add_child(xml.XMLPart(id="P1"))
    writer = _Writer(sheet.open_keys)
    for measure in sheet.measures:
        writer.measure(part.add_child(xml.XMLMeasure(number=str(measure.bar.number))), measure)
    head = '<?xml version="1.0" encoding="UTF-8" standalone="no"?>\n'
    return head + score.to_string()


class _Writer:
    """Writes measures one after another; knows what was said before."""

    def __init__(self, open_keys):
        self._open_keys = open_keys
        self._before = None
        self._latest = {}  # string -> notations and technical element of its latest note

    def measure(self, element, measure):
        bar = measure.bar
        self._attributes(element, bar)
        for marker in measure.markers:
            kind = element.add_child(xml.XMLDirection(placement="above")).add_child(xml.XMLDirectionType())
            kind.add_child(xml.XMLRehearsal(marker))
        if self._before is None or bar.quarter_us != self._before.quarter_us:
            _tempo(element, 60e6 / bar.quarter_us)
        self._before = bar
        whole = round(bar.quarters * DIVISIONS)
        starts = [(round(at * DIVISIONS), tones) for at, tones in measure.moments.items()]
        if not starts or starts[0][0] > 0:
            starts.insert(0, (0, []))
        for (start, tones), (end, _) in zip(starts, [*starts[1:], (whole, [])], strict=True):
            for k, length in enumerate(_values(start, end)):
                if length not in _VALUES:
                    element.add_child(xml.XMLForward()).add_child(xml.XMLDuration(length))
                elif k > 0 or not tones:
                    _value(element, length, rest=True)
                else:
                    self._chord(element, tones, length)

    def _attributes(self, element, bar):
        """What is new in a bar: key, time, and first of all the staff."""
        before, names = self._before, ("fifths", "numerator", "denominator")
        if before and all(getattr(bar, name) == getattr(before, name) for name in names):
            return
        attributes = element.add_child(xml.XMLAttributes())
        if before is None:
            attributes.add_child(xml.XMLDivisions(DIVISIONS))
            self._staff(attributes)
        attributes.add_child(xml.XMLKey()).add_child(xml.XMLFifths(bar.fifths))
        time = attributes.add_child(xml.XMLTime())
        time.add_child(xml.XMLBeats(str(bar.numerator)))
        time.add_child(xml.XMLBeatType(str(bar.denominator)))

    def _staff(self, attributes):
        clef = attributes.add_child(xml.XMLClef())
        clef.add_child(xml.XMLSign("TAB"))
        clef.add_child(xml.XMLLine(5))
        details = attributes.add_child(xml.XMLStaffDetails())
        details.add_child(xml.XMLStaffLines(len(self._open_keys)))
        for line, key in enumerate(self._open_keys, 1):
            letter, alter, octave = spell(key)
            tuning = details.add_child(xml.XMLStaffTuning(line=line))
            tuning.add_child(xml.XMLTuningStep(letter))
            if alter:
                tuning.add_child(xml.XMLTuningAlter(alter))
            tuning.add_child(xml.XMLTuningOctave(octave))

    def _chord(self, element, tones, length):
        """Notes that begin together, the lowest string first."""
        for k, tone in enumerate(sorted(tones, key=lambda tone: tone.string)):
            note = _value(element, length, tone.pitch, is_chord=k > 0, fifths=self._before.fifths)
            notations = note.add_child(xml.XMLNotations())
            technical = xml.XMLTechnical()
            self._slur(tone, notations, technical)
            technical.add_child(xml.XMLString(len(self._open_keys) - tone.string))
            technical.add_child(xml.XMLFret(tone.fret))
            notations.add_child(technical)
            self._latest[tone.string] = notations, technical

    def _slur(self, tone, notations, technical):
        """Tie a note that is not plucked to the one before it on its string."""
        if tone.string not in self._latest:
            return
        notations_before, technical_before = self._latest[tone.string]
        if tone.articulation == "slide":
            notations_before.add_child(xml.XMLSlide(type="start"))
            notations.add_child(xml.XMLSlide(type="stop"))
        elif tone.articulation in _LINES:
            kind, letter = _LINES[tone.articulation]
            technical_before.add_child(kind(letter, type="start"))
            technical.add_child(kind(type="stop"))


def _value(element, length, pitch=None, is_chord=False, rest=False, fifths=0):
    """Add a note or a rest of one note value."""
    name, dots, is_triplet = _VALUES[length]
    note = element.add_child(xml.XMLNote())
    if is_chord:
        note.add_child(xml.XMLChord())
    if rest:
        note.add_child(xml.XMLRest())
    else:
        letter, alter, octave = spell(pitch, fifths)
        place = note.add_child(xml.XMLPitch())
        place.add_child(xml.XMLStep(letter))
        if alter:
            place.add_child(xml.XMLAlter(alter))
        place.add_child(xml.XMLOctave(octave))
    note.add_child(xml.XMLDuration(length))
    note.add_child(xml.XMLVoice("1"))
    note.add_child(xml.XMLType(name))
    for _ in range(dots):
        note.add_child(xml.XMLDot())
    if is_triplet:
        change = note.add_child(xml.XMLTimeModification())
        change.add_child(xml.XMLActualNotes(3))
        change.add_child(xml.XMLNormalNotes(2))
    return note


def _tempo(element, per_minute):
    direction = element.add_child(xml.XMLDirection(placement="above"))
    metronome = direction.add_child(xml.XMLDirectionType()).add_child(xml.XMLMetronome())
    metronome.add_child(xml.XMLBeatUnit("quarter"))
    metronome.add_child(xml.XMLPerMinute(f"{per_minute:.6g}"))
    direction.add_child(xml.XMLSound(tempo=round(per_minute, 6)))


def _values(start, end):
    """Durations from one place in a bar to another of which each, if possible, is one note value."""
    found = []
    while start < end:
        left = end - start
        if left not in _VALUES:  # the largest value that leaves no less than the beat needs
            to_beat = min(left, DIVISIONS - start % DIVISIONS)
            whole = left if start % DIVISIONS == 0 else to_beat
            left = max((length for length in _VALUES if length <= whole), default=left)
        found.append(left)
        start += left
    return found
