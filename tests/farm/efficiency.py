#!/usr/bin/env python3
"""Measures how well workers share a sweep: the time of one worker, over that of several times their number.

There are two such figures. One worker may do the same job, part after part. Or it may make all pictures at once, and
trace only once; then the figure includes what tracing again costs.

    tests/farm/efficiency.py [--workers 2] [--pictures 200] [ILLUMINATOR]

Each worker has one thread, and so has the one process, so that the machine's processors stand for machines.
"""

import argparse
import subprocess
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).parents[2]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", nargs="?", default=ROOT / "target/release/illuminator", type=Path)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--pictures", type=int, default=200)
    parser.add_argument("--session", default="preset:default")
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--vary", default="floor.kd=0..0.5")
    options = parser.parse_args()
    sweep = ["sweep", options.session, "--size", options.size, "--threads", "1"]
    sweep += ["--vary", f"{options.vary}:{options.pictures}"]
    with tempfile.TemporaryDirectory() as folder:

        def run(*last):
            done = subprocess.run([options.program.resolve(), *sweep, *last], cwd=folder, capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
            return done.stdout

        print(run("-o", "frame-%04d.png", "--job", "openjd", "--job-file", "job.json").splitlines()[0])
        text = (Path(folder) / "job.json").read_text()
        parts = int(text.split('"range": "1-')[1].split('"')[0])
        parts = -(-parts // options.workers) * options.workers
        start = time.monotonic()
        run("-o", "alone-%04d.png")
        alone = time.monotonic() - start

        def job(name, count):
            start = time.monotonic()
            with ThreadPoolExecutor(count) as workers:
                list(workers.map(lambda part: run("-o", f"{name}-%04d.png", "--part", f"{part}/{parts}"), range(1, parts + 1)))
            run("-o", f"{name}-%04d.png", "--merge")
            return time.monotonic() - start

        single, shared = job("single", 1), job("shared", options.workers)
    print(f"all at once {alone:.2f} s; {parts} parts: one worker {single:.2f} s, {options.workers} workers {shared:.2f} s")
    efficiency = [whole / shared / options.workers for whole in (single, alone)]
    print(f"efficiency {efficiency[0]:.3f}; against all at once {efficiency[1]:.3f}")


main()
