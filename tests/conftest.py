"""Shared fixtures: the folder of third-party data that some tests compare with; turns of tests on JACK servers."""

import os
import pathlib
import tempfile

import pytest


@pytest.fixture(autouse=True, scope="session")
def _no_settings_of_ones_own(tmp_path_factory):
    """What knobs whoever runs the tests has taught `ukrt play` is none of theirs."""
    before = os.environ.get("UKRT_CONFIG_DIR")
    os.environ["UKRT_CONFIG_DIR"] = str(tmp_path_factory.mktemp("settings"))
    yield
    os.environ.pop("UKRT_CONFIG_DIR")
    if before is not None:
        os.environ["UKRT_CONFIG_DIR"] = before


@pytest.fixture(scope="session")
def shared_data():
    """The folder ``../shared/data`` beside the checkout; a test that needs it is skipped where it is absent."""
    folder = pathlib.Path(__file__).resolve().parents[2] / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(f"needs {folder.name} beside the checkout (../shared/data), which is absent")
    return folder


@pytest.fixture(autouse=True)
def _around_jack_tests(request):
    """Of all tests on JACK servers that this user runs, in whatever processes, one at a time.

    A client of JACK 2 listens on a socket named after the client and the user, not after its server, and removes what
    is there (posix/JackSocket.cpp): of two clients of one name that come to two servers at the same moment one fails.
    """
    if request.node.get_closest_marker("jack") is None:
        yield
        return
    import fcntl  # where there is jackd, there is this

    from ukrt.drivers.sound.scheduling import unlock_memory

    with open(pathlib.Path(tempfile.gettempdir()) / f"ukrt-jack-tests-{os.getuid()}.lock", "w") as turn:
        fcntl.flock(turn, fcntl.LOCK_EX)
        yield
        unlock_memory()  # which an output of JACK's has locked: to the tests that follow every allocation would be slow
