"""The job for Slurm: under a real Slurm of one node where it can be started, and the dry run."""

import os
import shutil
import socket
import subprocess
import time

import pytest
from conftest import SWEEP

CONFIGURATION = """ClusterName=one
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmdPort={node_port}
AuthType=auth/munge
CryptoType=crypto/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/controller.pid
SlurmdPidFile={folder}/node.pid
SlurmctldLogFile={folder}/controller.log
SlurmdLogFile={folder}/node.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_interval=1,batch_sched_delay=0
MinJobAge=3600
NodeName={host} NodeAddr=127.0.0.1 CPUs={processors} State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@pytest.fixture(scope="module")
def slurm(tmp_path_factory):
    """A Slurm of one node. Without the programs, or where it does not start, its tests are skipped."""
    programs = ["munged", "slurmctld", "slurmd", "sbatch"]
    path = os.environ["PATH"] + ":/usr/sbin"
    found = {name: shutil.which(name, path=path) for name in programs}
    if not all(found.values()) or os.getuid() != 0:
        pytest.skip("there is no Slurm here: apt-get install slurm-wlm munge, and be root")
    folder = tmp_path_factory.mktemp("slurm")
    for name in ["state", "spool"]:
        (folder / name).mkdir()
    settings = dict(host=socket.gethostname().split(".")[0], port=free_port(), node_port=free_port(), folder=folder)
    (folder / "slurm.conf").write_text(CONFIGURATION.format(processors=os.cpu_count(), **settings))
    (folder / "cgroup.conf").write_text("IgnoreSystemd=yes\nCgroupAutomount=yes\n")
    environment = {**os.environ, "PATH": path, "SLURM_CONF": str(folder / "slurm.conf")}
    if subprocess.run(["munge", "-n"], capture_output=True).returncode != 0:
        os.makedirs("/run/munge", exist_ok=True)
        shutil.chown("/run/munge", "munge", "munge")
        subprocess.run(["runuser", "-u", "munge", "--", found["munged"], "--force"], capture_output=True)
    started = [
        subprocess.Popen([found[name], "-D"], env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for name in ["slurmctld", "slurmd"]
    ]
    try:
        for _ in range(60):
            state = subprocess.run(["sinfo", "-h", "-o", "%t"], env=environment, capture_output=True, text=True).stdout
            if "idle" in state:
                break
            time.sleep(0.5)
        else:
            logs = "".join((folder / name).read_text()[-400:] for name in ["controller.log", "node.log"] if (folder / name).exists())
            pytest.skip(f"Slurm does not start here: {state}{logs}")
        yield environment
    finally:
        for process in started:
            process.terminate()
            process.wait()


def finished(environment, timeout=120):
    """Waits until no job waits or runs."""
    for _ in range(timeout * 4):
        if not subprocess.run(["squeue", "-h"], env=environment, capture_output=True, text=True).stdout.strip():
            return
        time.sleep(0.25)
    raise AssertionError("the jobs do not end")


def submit(illuminator, environment):
    done = subprocess.run(
        ["bash", "sheet.slurm.sh", "--time=5"], cwd=illuminator.folder, env=environment, capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_parts_run_as_an_array_and_the_last_step_merges_them(illuminator, slurm):
    illuminator(*SWEEP, "--job", "slurm", "--parts", "4")
    assert "the last step is job" in submit(illuminator, slurm)
    finished(slurm)
    assert (illuminator.folder / "sheet.png").read_bytes() == illuminator.direct()
    # A lost picture, and one that is damaged, are made again. The others are kept.
    before = illuminator.pictures()
    (illuminator.folder / "sheet-parts/0007.png").unlink()
    damaged = illuminator.folder / "sheet-parts/0031.png"
    damaged.write_bytes(damaged.read_bytes()[:1000])
    (illuminator.folder / "sheet.png").unlink()
    submit(illuminator, slurm)
    finished(slurm)
    after = illuminator.pictures()
    assert {name for name in after if before[name] != after[name]} == {"0007.png", "0031.png"}
    assert (illuminator.folder / "sheet.png").read_bytes() == (illuminator.folder / "direct.png").read_bytes()


def test_the_dry_run_does_the_same_without_slurm(illuminator):
    illuminator(*SWEEP, "--job", "slurm", "--parts", "3")
    done = subprocess.run(["bash", "sheet.slurm.sh", "--dry-run"], cwd=illuminator.folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("20 pictures made") == 3
    assert (illuminator.folder / "sheet.png").read_bytes() == illuminator.direct()
