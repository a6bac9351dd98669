"""Everything this package refuses, as one small tree of exceptions: each message is one sentence that names what was
found and what is legal."""


class UkrtError(Exception):
    """Root of all errors that are a user's to mend; anything else that is raised is a fault of the program."""


class ParameterError(UkrtError):
    """A parameter is missing, of the wrong type or out of its range.

    Attributes
    ----------
    key : str
        Dotted key relative to the object that was built, such as ``damping_ratios.3``.
    value : object
        What was found.
    legal : str
        What would have been legal.
    """

    def __init__(self, key, value, legal):
        self.key, self.value, self.legal = key, value, legal
        super().__init__(f"{key or 'the value'} is {_shown(value)}, but {legal}")

    def under(self, prefix):
        """The same complaint with its key seen from an outer object (``tension`` under ``strings.0``)."""
        key = f"{prefix}.{self.key}" if self.key else prefix
        return ParameterError(key, self.value, self.legal)


class PresetError(ParameterError):
    """A preset cannot be found, read or accepted; the message is one sentence that names the file and the key."""

    def __init__(self, message, key="", value=None, legal=""):
        self.key, self.value, self.legal = key, value, legal
        UkrtError.__init__(self, message)

    def under(self, prefix):
        return self


class MidiFileError(UkrtError):
    """A MIDI file cannot be read."""


class AudioFileError(UkrtError):
    """An audio file cannot be read or written."""


class ImpulseResponseError(UkrtError):
    """An impulse response cannot be found, read or used."""


class MeasurementError(UkrtError):
    """A measurement cannot be read, or nothing can be learned from it."""


class DeviceError(UkrtError):
    """A sound card or a MIDI port cannot be used."""


class MissingExtraError(UkrtError):
    """A command needs an optional package; the message names the extra to install."""


def _shown(value, limit=60):
    text = repr(value)
    return text if len(text) <= limit else text[: limit - 3] + "..."
