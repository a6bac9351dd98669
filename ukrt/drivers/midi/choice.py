"""Which of the MIDI inputs that there are shall be open: a wish and lists of ports enter, the ports to open leave."""

from ukrt.drivers.midi.port import devices, shown_name, stable_name

ALL = "all"


class Choice:
    """Remembers what was chosen, so that a port that comes back is known again by its name.

    Parameters
    ----------
    wanted : None, "all" or list of str
        None: one device, the first there is, and again the same when it comes back. A list: an index in the first list
        of ports, a name or a part of one for each input; the empty list for none.
    chosen : list of str
        Under None: the names of devices that were open before, the best liked first.
    """

    def __init__(self, wanted, chosen=()):
        self._wanted = wanted if wanted is None or wanted == ALL else [str(one) for one in wanted]
        self._chosen = list(chosen)
        self._looked, self._told = False, set()
        self._news = []

    def resolved(self):
        """The arguments for the `Choice` of a process that takes over from this one: without indices."""
        return {"wanted": self._wanted, "chosen": self._chosen}

    def news(self):
        """Sentences since the last call (list of str)."""
        news, self._news = self._news, []
        return news

    def ports(self, listed):
        """Those of ``listed`` that shall be open now (list of `Port`, each once)."""
        if not self._looked:
            self._looked = True
            self._resolve_indices(listed)
        if self._wanted is None:
            return self._first(devices(listed))
        if self._wanted == ALL:
            return devices(listed)
        found = [self._one(wanted, listed) for wanted in self._wanted]
        return list(dict.fromkeys(port for port in found if port is not None))

    def _resolve_indices(self, listed):
        if isinstance(self._wanted, list):
            self._wanted = [
                stable_name(listed[int(one)]) if one.isdecimal() and int(one) < len(listed) else one
                for one in self._wanted
            ]

    def _first(self, listed):
        by_name = {stable_name(port): port for port in reversed(listed)}
        for name in self._chosen:
            if name in by_name:
                return [by_name[name]]
        if not listed:
            return []
        self._chosen.append(stable_name(listed[0]))
        return listed[:1]

    def _one(self, wanted, listed):
        exact = [port for port in listed if wanted in (port.name, stable_name(port))]
        fitting = exact or [port for port in listed if wanted.casefold() in port.name.casefold()]
        if not fitting:
            there = ", ".join(shown_name(port) for port in listed) or "none on this machine"
            self._tell(wanted, f"there is no MIDI input {wanted!r} yet, there is {there}; it is opened when it appears")
            return None
        if len(fitting) > 1:
            taken, *rest = map(shown_name, fitting)
            self._tell((wanted, taken), f"{wanted!r} fits several MIDI inputs: {taken} is taken, not {', '.join(rest)}")
        return fitting[0]

    def _tell(self, subject, sentence):
        if subject not in self._told:
            self._told.add(subject)
            self._news.append(sentence)
