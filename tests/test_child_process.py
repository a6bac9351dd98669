"""Another Python, started wherever this one is: the same sources, and nothing that lies about in its folder."""

import json
import subprocess

import ukrt
from ukrt.child_process import python_module

_MODULE = """
import json, os, sys
import ukrt
print(json.dumps([ukrt.__file__, sys.argv[1:], os.environ["PYTHONPATH"]]))
"""


def test_a_module_finds_the_same_sources_from_any_folder(tmp_path, monkeypatch):
    (tmp_path / "elsewhere" / "ukrt").mkdir(parents=True)
    (tmp_path / "elsewhere" / "ukrt" / "__init__.py").write_text("raise SystemExit(3)")
    (tmp_path / "told.py").write_text(_MODULE)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    child = python_module("told", "one", "two words")
    got = subprocess.run(**child, cwd=tmp_path / "elsewhere", capture_output=True, text=True, check=True)
    source, arguments, path = json.loads(got.stdout)
    assert source == ukrt.__file__ and arguments == ["one", "two words"]
    assert path.endswith(str(tmp_path))
