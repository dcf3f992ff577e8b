#!/usr/bin/env python3
"""Prints the licences of the libraries that the program contains: a list, then each text once."""

import json
import pathlib
import re
import subprocess

NAMES = re.compile(r"^(licen[cs]e|copying|notice|ofl|ufl|unlicense|.*-licen[cs]e)", re.IGNORECASE)
TARGET = "x86_64-unknown-linux-gnu"


def contained():
    """The names and versions of the libraries in the program."""
    command = ["cargo", "tree", "--locked", "--edges", "normal,no-proc-macro", "--prefix", "none", "--format", "{p}"]
    command += ["--target", TARGET]
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    return {tuple(line.split(" ")[:2]) for line in lines if line}


def is_licence(path):
    """Whether a file is the text of a licence. Those of fonts have the names of the fonts."""
    if not path.is_file() or path.suffix in (".rs", ".html", ".json", ".hbs"):
        return False
    return bool(NAMES.match(path.name)) or path.suffix == ".txt" and any(path.parent.glob("*.[ot]tf"))


def main():
    command = ["cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", TARGET]
    metadata = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    wanted = contained()
    owners = {}
    print("The program contains these libraries. Their licences follow.\n")
    for package in sorted(metadata["packages"], key=lambda own: (own["name"], own["version"])):
        name = f"{package['name']} {package['version']}"
        if package["source"] is None or (package["name"], "v" + package["version"]) not in wanted:
            continue
        print(f"{name}: {package['license'] or package['license_file']}")
        folder = pathlib.Path(package["manifest_path"]).parent
        for path in sorted([*folder.glob("*"), *folder.glob("*/*")]):
            if is_licence(path):
                owners.setdefault(path.read_text(errors="replace").strip(), []).append(name)
    for text, names in owners.items():
        print(f"\n{'=' * 80}\n{', '.join(dict.fromkeys(names))}\n\n{text}")


if __name__ == "__main__":
    main()
