"""Which JACK ports belong together: a client's own ports and wishes enter, connections are made, news leave.

Devices come and go: whoever plays calls `Wiring.tend` now and then, and what fits the wishes is connected as it comes.
"""

from ukrt.drivers.jack.server import midi_sources, physical_outputs


class Wiring:
    """Keeps a client connected as wished.

    Parameters
    ----------
    client : jack.Client
    outs, ins : list of jack.OwnPort
        Audio outputs, MIDI inputs.
    connect : bool or str
    midi : bool, str or list of str
        See `ukrt.drivers.jack.client.JackOutput`.

    Attributes
    ----------
    lost : bool
        A source has gone that MIDI came from; whoever has seen to it sets it False.
    """

    def __init__(self, client, outs, ins, connect, midi):
        self._client, self._outs, self._ins = client, outs, ins
        self._connect = connect
        self._midi = [midi] if isinstance(midi, str) else midi
        self._seen = None  # the server's count of changes when its ports were last looked at
        self._heard = not connect
        self._offered, self._connected = set(), set()  # names: wished for and there; where MIDI comes from
        self.lost = False

    def tend(self, seen=0):
        """Connect what is there and wished for, if ports have come or gone; returns what there is to say (list)."""
        if seen == self._seen:
            return []
        news = []
        if not self._heard:
            self._connect_outputs(news)
        self._seen = seen
        if self._ins:
            self._connect_sources(news)
            self._compare_sources(news)
        return news

    def connections(self):
        """What each port is connected to (dict of short name -> list of names)."""
        return {port.shortname: [other.name for other in port.connections] for port in [*self._outs, *self._ins]}

    def _connect_outputs(self, news):
        """To one port for each channel, as soon as there is any; a single channel to the first two, for both sides."""
        targets = physical_outputs(self._client)
        if self._connect is not True:
            words = str(self._connect).casefold()
            everyone = self._client.get_ports(is_audio=True, is_input=True)
            targets = [port for port in everyone if words in port.name.casefold()]
        self._heard = bool(targets)
        if not targets and self._seen is None:
            wished = "no physical outputs" if self._connect is True else f"no audio inputs named {self._connect!r}"
            news.append(f"the JACK server has {wished} to connect to yet")
        sources = self._outs if len(self._outs) > 1 else self._outs * 2
        for source, target in zip(sources, targets, strict=False):
            self._join(source, target, news)

    def _connect_sources(self, news):
        """Every source that fits, once for each time that it appears: who disconnects it by hand is left in peace."""
        found = midi_sources(self._client, physical=self._midi is True) if self._midi else []
        if self._midi is not True:
            wished = [words.casefold() for words in self._midi or ()]
            found = [port for port in found if any(words in port.name.casefold() for words in wished)]
        for port in found:
            if port.name not in self._offered:
                self._join(port, self._ins[0], news)
        self._offered = {port.name for port in found}

    def _compare_sources(self, news):
        """What MIDI comes from now, by whoever's hand, and what it no longer comes from."""
        connected = {other.name for port in self._ins for other in port.connections}
        news += [f"MIDI from {name} is gone" for name in sorted(self._connected - connected)]
        news += [f"MIDI from {name} is connected" for name in sorted(connected - self._connected)]
        self.lost |= bool(self._connected - connected)
        self._connected = connected

    def _join(self, source, target, news):
        """Connect two ports; a port that has just gone away is news and no error."""
        import jack

        try:
            self._client.connect(source, target)
        except jack.JackErrorCode as error:
            if error.code != 17:  # EEXIST: connected already, by a session manager perhaps
                news.append(f"JACK does not connect {source.name} to {target.name}: {error}")
        except jack.JackError as error:
            news.append(f"JACK does not connect {source.name} to {target.name}: {error}")
