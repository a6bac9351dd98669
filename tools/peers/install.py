"""Peers from Debian: asked for by name, installed by apt-get as root; what cannot be had is left out, not fatal.

Nothing is ever removed for a peer: STK's package wants JACK's headers, and Debian's first choice of those would put
jackd1 in the place of jackd2, which ukrt's own tests play on.
"""

import os

from .peer import PeerError, called


def missing_packages(packages):
    """Those of the packages that dpkg does not know as installed (list of str)."""
    return [name for name in dict.fromkeys(packages) if not _is_installed(name)]


def _is_installed(package):
    try:
        return called("dpkg-query", "-W", "-f=${db:Status-Status}", package).strip() == "installed"
    except PeerError:
        return False


# A package that has to take another away fails instead, and its peer is left out.
APT_INSTALL = ("install", "-y", "-qq", "--no-install-recommends", "--no-remove")


def install(packages, say):
    """Install each package that is missing; returns why some could not be (dict of str to str)."""
    wanted = missing_packages(packages)
    if not wanted:
        return {}
    if not hasattr(os, "geteuid") or os.geteuid() != 0:
        return dict.fromkeys(wanted, f"apt-get needs root: sudo apt-get install {' '.join(wanted)}")
    failed = {}
    quiet = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
    try:
        say("asking apt-get for its package lists")
        called("apt-get", "update", "-qq", env=quiet)
    except PeerError as error:
        say(f"going on without new lists: {error}")
    for name in wanted:
        say(f"installing {name}")
        try:
            called("apt-get", *APT_INSTALL, name, env=quiet, timeout=1800)
        except PeerError as error:
            failed[name] = str(error)
    return failed
