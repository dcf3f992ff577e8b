"""The job for the Open Job Description, as its own runner takes it."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from conftest import SWEEP

OPENJD = Path(sys.executable).with_name("openjd")


def start(folder, *arguments):
    command = [OPENJD, "run", "sheet.openjd.json", *arguments]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def run(folder, *arguments):
    job = start(folder, *arguments)
    output, _ = job.communicate(timeout=300)
    assert job.returncode == 0, output
    return output


def test_the_template_is_valid_and_makes_the_sheet(illuminator):
    illuminator(*SWEEP, "--job", "openjd", "--parts", "4")
    checked = subprocess.run([OPENJD, "check", "sheet.openjd.json"], cwd=illuminator.folder, capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    run(illuminator.folder)
    assert len(illuminator.pictures()) == 60
    assert (illuminator.folder / "sheet.png").read_bytes() == illuminator.direct()


def test_a_killed_worker_loses_nothing_and_nothing_is_done_twice(illuminator):
    illuminator(*SWEEP, "--job", "openjd", "--parts", "3")
    job = start(illuminator.folder)
    deadline = time.monotonic() + 120
    while len(illuminator.pictures()) < 25:
        assert time.monotonic() < deadline and job.poll() is None
        time.sleep(0.005)
    # The worker, not the runner: it has no chance to clean up.
    workers = subprocess.run(["pgrep", "-f", f"{illuminator.folder}.*--part"], capture_output=True, text=True).stdout.split()
    workers = workers or subprocess.run(["pgrep", "-f", "illuminator sweep.*--part"], capture_output=True, text=True).stdout.split()
    assert workers
    for worker in workers:
        os.kill(int(worker), signal.SIGKILL)
    output, _ = job.communicate(timeout=60)
    assert job.returncode != 0, output
    before = illuminator.pictures()
    assert 25 <= len(before) < 60 and not (illuminator.folder / "sheet.png").exists()
    output = run(illuminator.folder)
    after = illuminator.pictures()
    # What was complete was not written again, and the rest was made once.
    assert {name: after[name] for name in before} == before and len(after) == 60
    made = [line.split(": ")[1] for line in output.splitlines() if "pictures made" in line]
    assert sum(int(line.split()[0]) for line in made) == 60 - len(before)
    assert (illuminator.folder / "sheet.png").read_bytes() == illuminator.direct()
    assert not list((illuminator.folder / "sheet-parts").glob(".illuminator-*"))


def test_one_task_alone_can_be_run(illuminator):
    illuminator(*SWEEP, "--job", "openjd", "--parts", "6")
    run(illuminator.folder, "--step", "Parts", "--task-param", "Part=2")
    assert sorted(illuminator.pictures()) == [f"{number:04}.png" for number in range(11, 21)]


def test_a_job_elsewhere_is_told_its_folder(illuminator, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("jobs")
    illuminator(*SWEEP, "--job", "openjd", "--job-file", str(elsewhere / "sheet.openjd.json"), "--parts", "1")
    template = json.loads((elsewhere / "sheet.openjd.json").read_text())
    assert "default" not in template["parameterDefinitions"][0]
    run(elsewhere, "-p", f"Folder={illuminator.folder}")
    assert (illuminator.folder / "sheet.png").exists()
