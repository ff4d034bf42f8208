#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What a capture costs a paced run: the same run with and without --capture, in turns.

    docs/measure_capture.py [--bodies 2000] [--frames 240] [--rounds 20] [--poise build/release/src/app/poise]

Each frame's time is the median over the rounds, since the runs do the same work in the same frame; percentiles are those of
these medians. The interval of the ratio is a bootstrap over the rounds (95 %, percentiles). Needs 2 * rounds * frames / 60 s.
"""
import argparse
import csv
import pathlib
import random
import statistics
import subprocess
import sys
import tempfile

DRAWS = 300


def frame_times(poise, arguments, folder, captured):
    """Milliseconds of each frame of one run."""
    table = folder / "frames.csv"
    command = [poise, "run", "jacks", "--deadline", "16", "--paced", "--no-time-priors", "--quiet", "--frames-csv", table, *arguments]
    if captured:
        command += ["--capture", folder / "run.capture"]
    done = subprocess.run([str(word) for word in command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{command[0]} ended with {done.returncode}: {done.stderr.strip()}")
    (folder / "run.capture").unlink(missing_ok=True)
    with open(table, encoding="utf-8") as rows:
        return [float(row["total_ms"]) for row in csv.DictReader(rows)]


def percentile(runs, share):
    times = sorted(statistics.median(frame) for frame in zip(*runs))
    return times[min(len(times) - 1, int(share * len(times)))]


def main():
    root = pathlib.Path(__file__).resolve().parent.parent
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bodies", type=int, default=2000)
    parser.add_argument("--frames", type=int, default=240)
    parser.add_argument("--rounds", type=int, default=20)
    parser.add_argument("--poise", default=str(root / "build/release/src/app/poise"))
    o = parser.parse_args()
    if min(o.bodies, o.frames, o.rounds) < 1:
        parser.error("--bodies, --frames and --rounds must be at least 1")
    arguments = ["--bodies", o.bodies, "--frames", o.frames]
    runs = {False: [], True: []}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        frame_times(o.poise, arguments, folder, False)  # trees are built here
        for turn in range(o.rounds):
            for captured in (False, True) if turn % 2 == 0 else (True, False):
                runs[captured].append(frame_times(o.poise, arguments, folder, captured))
    draw = random.Random(1)
    print("| | without ms | with ms | ratio | 95 % from | to |\n|---|---|---|---|---|---|")
    for share in (0.5, 0.9, 0.99):
        without, captured = percentile(runs[False], share), percentile(runs[True], share)
        ratios = []
        for _ in range(DRAWS):
            rounds = [draw.randrange(o.rounds) for _ in range(o.rounds)]
            ratios.append(percentile([runs[True][i] for i in rounds], share) / percentile([runs[False][i] for i in rounds], share))
        ratios.sort()
        low, high = ratios[int(0.025 * DRAWS)], ratios[int(0.975 * DRAWS)]
        print(f"| p{100 * share:g} | {without:.3f} | {captured:.3f} | {captured / without:.3f} | {low:.3f} | {high:.3f} |")


if __name__ == "__main__":
    main()
