#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How many bodies fit a deadline: the population of a scene is doubled until frames are late.

A frame counts as late where Poise was the cause; frames that the system made late are shown, and do not count. The first ten
frames of a population, in which memory is allocated, are left out.

    examples/python/stress.py --scene jacks --deadline-ms 8
"""
import argparse
import sys

import poise

WARM_UP = 10


def whole(text):
    """A whole number above 0."""
    number = int(text)
    if number <= 0:
        raise ValueError
    return number


def options():
    parser = argparse.ArgumentParser(description="How many bodies of a scene fit a deadline.")
    parser.add_argument("--scene", default="jacks", help="a scene with generators (default: jacks)")
    parser.add_argument("--deadline-ms", type=float, default=8, help="of a frame, from its start (default: 8)")
    parser.add_argument("--frames", type=whole, default=300, help="frames of each population (default: 300)")
    parser.add_argument("--most", type=whole, default=20000, help="bodies to end with (default: 20000)")
    parser.add_argument("--misses", type=float, default=0.01, help="share of late frames that is allowed (default: 0.01)")
    parser.add_argument("--threads", type=int, default=0, help="of a step; 0: as many as the machine has")
    return parser.parse_args()


def main():
    asked = options()
    budget = poise.Budget.within(asked.deadline_ms / 1000)
    fits = None
    print("bodies   late frames   p50 ms   p99 ms   mean level   causes")
    bodies = 10
    while bodies <= asked.most:
        run = poise.SceneRun(asked.scene, bodies=bodies, threads=asked.threads)
        run.run(WARM_UP, budget)
        rows = [report.as_dict() for report in run.run(asked.frames, budget)]
        times = sorted(row["total_ms"] for row in rows)
        late = [row["cause"] for row in rows if row["miss"]]
        levels = [sum(row["level_%d" % level] for row in rows) for level in range(7)]
        mean = sum(level * count for level, count in enumerate(levels)) / max(1, sum(levels))
        causes = ", ".join("%s %d" % (cause, late.count(cause)) for cause in sorted(set(late)))
        print("%6d   %11d   %6.2f   %6.2f   %10.2f   %s" % (
            bodies, len(late), times[len(times) // 2], times[int(0.99 * (len(times) - 1))], mean, causes or "-"))
        if len(late) - late.count("machine") > asked.misses * len(rows):
            break
        fits = bodies
        bodies *= 2
    if fits is None:
        print("not even 10 bodies fit %g ms" % asked.deadline_ms)
    else:
        print("%d bodies of %s fit %g ms" % (fits, asked.scene, asked.deadline_ms))
    return 0


if __name__ == "__main__":
    sys.exit(main())
