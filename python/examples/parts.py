"""A sweep that workers share: what each of them does, and the contact sheet. The examples for Dask and Ray use it."""

import argparse
import json
import math
import os
import sys
from pathlib import Path

import illuminator
from PIL import Image

SESSIONS = {}


def open_session(arguments):
    """The session of a worker. It keeps its rays from part to part."""
    key = (arguments["session"], tuple(arguments["size"]))
    if key not in SESSIONS:
        # Each worker process has one thread, so that as many workers as processors do not get in each other's way.
        SESSIONS[key] = illuminator.Session(arguments["session"], size=arguments["size"], threads=1)
    return SESSIONS[key]


def make_part(arguments, part):
    """Makes the pictures of a part that are not there yet. Returns how many it made, and the process that did so.

    `save` writes a file whole or not at all, so a file that is there is complete, also if a worker was killed.
    """
    session, made = open_session(arguments), 0
    for number, values in part:
        path = Path(arguments["folder"]) / f"{number:04}.png"
        if not path.exists():
            session.set(values)
            session.save(path)
            made += 1
    return made, os.getpid()


def read_arguments(description):
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("session", nargs="?", default="preset:studio")
    parser.add_argument("--vary", action="append", required=True, help="as for illuminator sweep")
    parser.add_argument("--size", default="320x240")
    parser.add_argument("--folder", default="pictures", help="a folder that all workers see")
    parser.add_argument("--chunk", type=int, default=25, help="pictures in a part: a worker traces once for all its parts")
    parser.add_argument("--workers", type=int, default=2)
    arguments = vars(parser.parse_args())
    arguments["size"] = [int(side) for side in arguments["size"].split("x")]
    return arguments


def share_out(arguments):
    """The parts: lists of pictures, each with its number and values."""
    Path(arguments["folder"]).mkdir(parents=True, exist_ok=True)
    session = illuminator.Session(arguments["session"], size=arguments["size"])
    # Pictures of another sweep are not taken for those of this one.
    record = Path(arguments["folder"]) / "sweep.json"
    sweep = json.dumps({"session": session.keys(), "text": session.formula.text, **arguments, "chunk": 0, "workers": 0})
    if record.exists() and record.read_text() != sweep:
        sys.exit(f"the pictures in {arguments['folder']} are of another sweep; give --folder another name")
    record.write_text(sweep)
    pictures = list(enumerate(session.variations(*arguments["vary"]), start=1))
    chunk = arguments["chunk"]
    return [pictures[first : first + chunk] for first in range(0, len(pictures), chunk)]


def merge(arguments, parts, results):
    """The last step: a contact sheet of all pictures."""
    count = sum(len(part) for part in parts)
    columns = math.ceil(math.sqrt(count))
    width, height = arguments["size"]
    sheet = Image.new("RGB", (columns * width, math.ceil(count / columns) * height), "white")
    for number in range(count):
        with Image.open(Path(arguments["folder"]) / f"{number + 1:04}.png") as picture:
            sheet.paste(picture, (number % columns * width, number // columns * height))
    partial = Path(arguments["folder"]) / ".sheet.png"
    sheet.save(partial)
    partial.rename(Path(arguments["folder"]) / "sheet.png")
    made, workers = sum(made for made, _ in results), {worker for _, worker in results}
    print(f"{count} pictures in {len(parts)} parts by {len(workers)} workers: {made} made, {count - made} kept")
