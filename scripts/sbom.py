#!/usr/bin/env python3
"""Prints a bill of materials of the program: the crates that it is built from, their licences and checksums, as CycloneDX 1.5.

    scripts/sbom.py [TARGET]
"""

import json
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def crates(target):
    """Crates linked into `pathmarch` on a target, by the features of its package."""
    tree = ["cargo", "tree", "--locked", "-p", "pathmarch", "-e", "normal", "--prefix", "none", "--format", "{p}|{l}"]
    tree += ["--target", target] if target else []
    lines = subprocess.run(tree, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
    found = set()
    for line in lines:
        name_and_version, licence = line.removesuffix(" (*)").split("|")
        name, version = name_and_version.split(" ")[:2]
        found.add((name, version.removeprefix("v"), licence))
    return sorted(found)


def checksums():
    """Checksums of the lock file by name and version."""
    lock = tomllib.loads((ROOT / "Cargo.lock").read_text())
    return {(package["name"], package["version"]): package.get("checksum") for package in lock["package"]}


def component(name, version, licence, checksum):
    """One crate in the words of CycloneDX."""
    described = {
        "type": "library",
        "name": name,
        "version": version,
        "purl": f"pkg:cargo/{name}@{version}",
        "licenses": [{"expression": licence.replace("/", " OR ")}] if licence else [],
    }
    if checksum:
        described["hashes"] = [{"alg": "SHA-256", "content": checksum}]
    return described


def main():
    known = checksums()
    found = crates(sys.argv[1] if len(sys.argv) > 1 else None)
    own = next(crate for crate in found if crate[0] == "pathmarch")
    parts = [component(*crate, known.get(crate[:2])) for crate in found if crate is not own]
    bill = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": component(*own, None) | {"type": "application"}},
        "components": parts,
    }
    print(json.dumps(bill, indent=1))


if __name__ == "__main__":
    main()
