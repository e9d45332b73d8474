#!/usr/bin/env python3
"""Prints the licences of the crates in the program, with their texts and notices, which must go with every copy of it.

    scripts/notices.py [TARGET]

A crate without a file of its licence is listed with the name of the licence.
"""

import json
import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

from sbom import ROOT, crates

FILES = re.compile(r"(^|[-_])(licen[cs]e|copying|notice|copyright|unlicense|ofl|ufl)", re.IGNORECASE)
RULE = "-" * 80


def folders():
    """Folder of each crate's source by name and version."""
    command = ["cargo", "metadata", "--locked", "--format-version", "1"]
    metadata = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout)
    return {(package["name"], package["version"]): Path(package["manifest_path"]).parent for package in metadata["packages"]}


def texts(folder):
    """Texts of the licences and notices of a crate, also those of fonts in folders within it."""
    files = sorted(file for file in folder.rglob("*") if FILES.match(file.name) and file.suffix not in (".rs", ".json"))
    return [file.read_text(encoding="utf-8", errors="replace").strip() for file in files if file.is_file()]


def main():
    places = folders()
    found = [crate for crate in crates(sys.argv[1] if len(sys.argv) > 1 else None) if crate[0] != "pathmarch"]
    users = defaultdict(list)
    print("pathmarch contains the following works.\n")
    for name, version, licence in found:
        print(f"{name} {version}: {licence}")
        for text in texts(places[name, version]):
            users[text].append(f"{name} {version}")
    for text, names in users.items():
        print(f"\n{RULE}\n{', '.join(names)}\n{RULE}\n\n{text}")


if __name__ == "__main__":
    main()
