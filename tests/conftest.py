"""Shared fixtures: the folder of third-party data that some tests compare with."""

import pathlib

import pytest


@pytest.fixture(scope="session")
def shared_data():
    """The folder ``../shared/data`` beside the checkout; a test that needs it is skipped where it is absent."""
    folder = pathlib.Path(__file__).resolve().parents[2] / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(f"needs {folder.name} beside the checkout (../shared/data), which is absent")
    return folder
