"""What the cases of several figures share: the paper's guitar, its finger with other contacts, the finger's places."""

from dataclasses import replace

from ..model.presets import load_preset

FIFTH_FRET = 0.2509  # of L from the nut: Figs. 6 and 7


def paper_guitar():
    """The preset ``paper`` (ukrt.model.parameters.Guitar)."""
    return load_preset("paper")


def with_contacts(guitar, *contacts):
    """The guitar with a finger of these contacts (ukrt.model.parameters.Contact), and no damping hand beside it."""
    finger, damper = replace(guitar.finger, contacts=contacts), replace(guitar.damper, places=())
    return replace(guitar, finger=finger, damper=damper)
