#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What `poise sweep` adds to its trials: many trials of one second each, by several workers of this machine.

    docs/measure_sweep.py [--trials 1000] [--workers 2] [--frames 61] [--poise build/release/src/app/poise]

A trial is `two-body` with --paced, which releases a frame each 1/60 s and sleeps between them, so that it takes the same time
on any machine that is not overloaded, and hardly needs its processor: 61 frames begin in 60 such steps, one second. The ideal is
these steps of all trials, shared among the workers, with nothing between them: start and end of a trial's process count as
added. Ends with 1 where trials failed. Needs trials * (frames - 1) / 60 / workers seconds.
"""
import argparse
import csv
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

FRAME_S = 1 / 60


def main():
    root = pathlib.Path(__file__).resolve().parent.parent
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=1000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--frames", type=int, default=61)
    parser.add_argument("--poise", default=str(root / "build/release/src/app/poise"))
    o = parser.parse_args()
    if min(o.trials, o.workers, o.frames - 1) < 1:
        parser.error("--trials and --workers must be at least 1, --frames at least 2")
    if o.workers > len(os.sched_getaffinity(0)):
        parser.error(f"--workers = {o.workers}, must be at most the {len(os.sched_getaffinity(0))} processors: a paced trial has its own")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        spec = folder / "spec.json"
        spec.write_text(json.dumps({"schema": "poise.sweep/1", "scenes": ["two-body"], "repeats": o.trials,
                                    "settings": {"frames": o.frames, "paced": True, "deadline_ms": 16, "threads": 1}}))
        load = os.getloadavg()[0]
        began = time.monotonic()
        code = subprocess.run([o.poise, "sweep", str(spec), "--workers", str(o.workers), "--quiet", "--out", str(folder / "out")],
                              check=False).returncode
        took_s = time.monotonic() - began
        with open(folder / "out/trials.csv", encoding="utf-8") as table:
            rows = list(csv.DictReader(table))
    done = [float(row["seconds"]) for row in rows if row["state"] == "done"]
    if code != 0 or len(done) != o.trials:
        sys.exit(f"{len(done)} of {o.trials} trials are done, exit code {code}")
    ideal_s = -(-o.trials // o.workers) * (o.frames - 1) * FRAME_S
    trials_s = sum(done) / o.workers
    print(f"{o.trials} trials, {o.workers} workers, commit {rows[0]['commit']}, {rows[0]['processor']}, "
          f"load {load:.1f} to {os.getloadavg()[0]:.1f}\n\n"
          f"| | s | over the ideal |\n|---|---|---|\n| ideal: {o.frames - 1} steps a trial | {ideal_s:.1f} | 1 |\n"
          f"| trials, with start and end of their processes | {trials_s:.1f} | {trials_s / ideal_s:.3f} |\n"
          f"| the sweep | {took_s:.1f} | {took_s / ideal_s:.3f} |")


if __name__ == "__main__":
    main()
