#!/usr/bin/env python3
"""Renders a still in parts on a Dask cluster, and merges them.

    render.py SCENE SAMPLES PARTS OUTPUT [--scheduler ADDRESS] [--workers N] [--only A-B]
        [--options OPTIONS]

Without a scheduler it starts workers on this machine. The files are on a file system that all workers share. A part whose
worker is lost runs again on another one. PATHMARCH names the program.
"""

import argparse
import os
import pathlib
import subprocess

from dask.distributed import Client, as_completed

FARM = pathlib.Path(__file__).resolve().parent.parent


def render(scene, samples, parts, options, index, output):
    """Renders one part and returns its film."""
    film = f"{output}.parts/{index}.film"
    subprocess.run([FARM / "part.sh", scene, str(samples), parts, str(index), film, *options], check=True)
    return film


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("scene")
    parser.add_argument("samples", type=int)
    parser.add_argument("parts", help="number of parts, or a list of their ends such as 0,5,17,64")
    parser.add_argument("output")
    parser.add_argument("--scheduler", help="address of a running scheduler")
    parser.add_argument("--workers", type=int, default=2, help="workers on this machine, without a scheduler")
    parser.add_argument("--only", help="indices of the parts to render, as in 0-3; no merge then")
    parser.add_argument("--options", default="", help="further options of pathmarch render")
    options = parser.parse_args()
    os.makedirs(f"{options.output}.parts", exist_ok=True)
    count = options.parts.count(",") or int(options.parts)
    first, last = (int(end) for end in (options.only or f"0-{count - 1}").split("-"))
    if options.scheduler:
        client = Client(options.scheduler)
    else:
        client = Client(n_workers=options.workers, threads_per_worker=1, dashboard_address=None)
    with client:
        job = (options.scene, options.samples, options.parts, options.options.split())
        futures = [
            client.submit(render, *job, index, options.output, retries=3, pure=False)
            for index in range(first, last + 1)
        ]
        films = [future.result() for future in as_completed(futures)]
    if not options.only:
        program = os.environ.get("PATHMARCH", "pathmarch")
        subprocess.run([program, "merge", *sorted(films), "-o", options.output], check=True)


if __name__ == "__main__":
    main()
