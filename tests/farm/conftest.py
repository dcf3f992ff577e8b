"""Jobs for render farms: the program that makes them, and a folder with a session."""

import os
import subprocess
from pathlib import Path

import pytest

PROGRAM = Path(os.environ.get("ILLUMINATOR", Path(__file__).parents[2] / "target/release/illuminator"))
# Enough work that a worker can be killed in the middle of it.
SWEEP = "sweep preset:studio --size 320x240 --threads 1 --vary ball.kd=0..0.7:60 -o sheet.png".split()


class Illuminator:
    """The program in a folder."""

    def __init__(self, folder):
        self.folder = folder

    def __call__(self, *arguments):
        done = subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    def pictures(self):
        """The complete pictures of the parts, with the times when they were written."""
        found = (self.folder / "sheet-parts").glob("[0-9]*.png")
        return {path.name: path.stat().st_mtime_ns for path in found}

    def direct(self):
        """The bytes of the same sheet without parts."""
        self(*SWEEP[:-1], "direct.png")
        return (self.folder / "direct.png").read_bytes()


@pytest.fixture
def illuminator(tmp_path):
    return Illuminator(tmp_path)
