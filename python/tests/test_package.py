"""The package itself: stubs, widgets, the notebook, and Ctrl+C."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import illuminator
import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"


def test_the_stubs_describe_the_package():
    pytest.importorskip("mypy")
    found = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "illuminator", "--ignore-missing-stub"], capture_output=True, text=True
    )
    assert found.returncode == 0, found.stdout + found.stderr


def test_the_notebook_runs():
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(EXAMPLES / "tour.ipynb", as_version=4)
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": EXAMPLES}}).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    pictures = [output for output in outputs if "image/png" in output.get("data", {})]
    assert len(pictures) >= 4, "a session, a drag, a lobe, and two models"


def test_sliders_move_the_picture():
    pytest.importorskip("ipywidgets")
    from illuminator.widgets import sliders

    session = illuminator.Session("preset:default", size=(64, 48))
    box = sliders(session)
    image, column = box.children
    rows = {row.description: row for row in column.children}
    assert {name.split(".")[-1] for name in rows} == {"ka", "ki", "kr", "kt", "kd", "ks", "h"}
    before, name = image.value, next(name for name in rows if name.endswith(".kd"))
    rows[name].value = 0.125
    assert image.value != before and session[name] == pytest.approx(0.125)
    with pytest.raises(ValueError, match="no slider"):
        sliders(session, ["background"])


def test_an_interrupt_ends_the_work():
    code = (
        "import illuminator; s = illuminator.Session('preset:default', size=(1920, 1080), samples=4096)\n"
        "print('begun', flush=True)\ns.render()"
    )
    work = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert work.stdout.readline() == "begun\n"
    time.sleep(0.5)
    os.kill(work.pid, signal.SIGINT)
    _, errors = work.communicate(timeout=60)
    assert "KeyboardInterrupt" in errors and work.returncode != 0
