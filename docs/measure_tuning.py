#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What a search of weights does with its time: `poise tune` of several workers on one journal, and what the journal says.

    docs/measure_tuning.py [--trials 200] [--workers 2] [--poise build/release/src/app/poise] [OPTION OF poise tune]...

Searches the default fields on `jacks` and `street`, 120 bodies each, one seed, budgets counted in work, so that a policy has the
same value wherever it is tried. The time from the first trial to the end of the last one is that of the search: states are made
before it, and rivals are measured behind it. What a worker adds to a trial is that time, less what was spent in stepping.
Needs Optuna (python3-optuna).
"""
import argparse
import collections
import datetime
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

# Numbers of Optuna's journal: kinds of lines, and the state of a trial that is done.
CREATE_TRIAL, SET_STATE, SET_USER_ATTRIBUTE = 4, 6, 8
DONE = 1
MARKS = (50, 100, 150, 200)


def read_trials(journal):
    """The trials that are done: start and end in s, value, stepped_s and worker; those that end first come first."""
    trials = []
    with open(journal, encoding="utf-8") as lines:
        for line in map(json.loads, lines):
            kind = line["op_code"]
            if kind == CREATE_TRIAL:
                trials.append({"start": line.get("datetime_start")})
            elif kind == SET_STATE:
                trial = trials[line["trial_id"]]
                trial["start"] = line.get("datetime_start", trial["start"])
                if line["state"] == DONE:
                    trial.update(end=line["datetime_complete"], value=line["values"][0])
            elif kind == SET_USER_ATTRIBUTE:
                trials[line["trial_id"]].update(line["user_attr"])
    done = [trial for trial in trials if "end" in trial]
    for trial in done:
        for name in ("start", "end"):
            trial[name] = datetime.datetime.fromisoformat(trial[name]).timestamp()
    return sorted(done, key=lambda trial: trial["end"])


def main():
    root = pathlib.Path(__file__).resolve().parent.parent
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], allow_abbrev=False)
    parser.add_argument("--trials", type=int, default=200)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--poise", default=str(root / "build/release/src/app/poise"))
    o, more = parser.parse_known_args()
    with tempfile.TemporaryDirectory() as name:
        out = str(pathlib.Path(name) / "mine.json")
        command = [o.poise, "tune", "jacks", "street", "--bodies", "120", "--seeds", "1", "--holdout-seeds", "11", "--rivals", "size",
                   "--frames", "4", "--trials", str(o.trials), "--workers", str(o.workers), "--quiet", "--out", out, *more]
        load = os.getloadavg()[0]
        began = time.monotonic()
        if subprocess.run(command, check=False).returncode != 0:
            sys.exit("poise tune has failed")
        took_s = time.monotonic() - began
        trials = read_trials(out + ".journal")
        with open(out, encoding="utf-8") as file:
            evidence = json.load(file)["evidence"]
    workers = collections.Counter(trial["worker"] for trial in trials)
    search_s = trials[-1]["end"] - min(trial["start"] for trial in trials)
    stepped_s = sum(trial["stepped_s"] for trial in trials)
    best = [min(trial["value"] for trial in trials[:mark]) for mark in MARKS if mark <= len(trials)]
    print(f"commit {evidence['build']['commit']}, {evidence['machine'].get('processor', '?')}, load {load:.1f} to {os.getloadavg()[0]:.1f}\n\n"
          "| trials | workers (trials of each) | command | search | stepping, a trial | added to a trial | best after "
          + ", ".join(str(mark) for mark in MARKS[:len(best)]) + " |\n|---|---|---|---|---|---|---|\n"
          f"| {len(trials)} | {len(workers)} ({', '.join(str(count) for count in workers.values())}) | {took_s:.1f} s | {search_s:.1f} s | "
          f"{stepped_s / len(trials) * 1e3:.0f} ms | {(len(workers) * search_s - stepped_s) / len(trials) * 1e3:.0f} ms | "
          + ", ".join(f"{value:+.4f}" for value in best) + " |")


if __name__ == "__main__":
    main()
