"""The examples for clusters, on two workers of this machine."""

import re
import subprocess
import sys
from pathlib import Path

import illuminator
import numpy as np
import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"


@pytest.mark.parametrize("name, library", [("dask_sweep", "distributed"), ("ray_sweep", "ray")])
def test_two_workers_share_a_sweep_and_keep_what_is_there(tmp_path, name, library):
    pytest.importorskip(library)
    image = pytest.importorskip("PIL.Image")
    vary = "ball.kd=0..0.6:24"

    def run():
        command = [sys.executable, EXAMPLES / f"{name}.py", "preset:studio", "--vary", vary, "--size", "96x72", "--chunk", "4"]
        done = subprocess.run([*command, "--folder", tmp_path], capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stdout + done.stderr
        return [int(number) for number in re.findall(r"\d+", done.stdout.splitlines()[-1])]

    # Pictures, parts, workers, made, kept. A worker that starts late may find nothing left to do.
    pictures, parts, workers, made, kept = run()
    assert (pictures, parts, made, kept) == (24, 6, 24, 0) and workers in (1, 2)
    session = illuminator.Session("preset:studio", size=(96, 72))
    values = session.variations(vary)
    for number in [1, 10, 24]:
        session.set(values[number - 1])
        picture = np.asarray(image.open(tmp_path / f"{number:04}.png"))
        assert np.array_equal(picture, session.image())
    sheet = np.asarray(image.open(tmp_path / "sheet.png"))
    assert sheet.shape == (5*72, 5*96, 3) and np.array_equal(sheet[:72, :96], image.open(tmp_path / "0001.png"))
    for number in [3, 4, 20]:
        (tmp_path / f"{number:04}.png").unlink()
    assert run()[3:] == [3, 21]
