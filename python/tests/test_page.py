"""The examples in the manual's chapter about Python."""

import re
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs/manual/src/python.md"


def test_every_example_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    examples = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(), re.DOTALL | re.MULTILINE)
    assert len(examples) >= 10
    names = {}
    for example in examples:
        exec(compile(example, str(PAGE), "exec"), names)
    assert (tmp_path / "studio.png").read_bytes().startswith(b"\x89PNG")
