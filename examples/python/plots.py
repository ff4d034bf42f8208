#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws the stages of each frame and the levels of its contacts, by Matplotlib, into plots.png.

    examples/python/plots.py --scene jacks --bodies 500 --deadline-ms 8
"""
import argparse
import sys

import poise

STAGES = ["predict", "broad_phase", "coarse", "refine", "manifolds", "solve", "integrate", "publish"]


def whole(text):
    """A whole number above 0."""
    number = int(text)
    if number <= 0:
        raise ValueError
    return number


def main():
    parser = argparse.ArgumentParser(description="Draws the frames of a run.")
    parser.add_argument("--scene", default="jacks")
    parser.add_argument("--bodies", type=whole, default=500)
    parser.add_argument("--frames", type=whole, default=200)
    parser.add_argument("--deadline-ms", type=float, default=8)
    parser.add_argument("--out", default="plots.png")
    asked = parser.parse_args()
    run = poise.SceneRun(asked.scene, bodies=asked.bodies)
    frames = poise.frames_table(run.run(asked.frames, poise.Budget.within(asked.deadline_ms / 1000)))
    print("%d frames of %d bodies, %d of them late" % (asked.frames, asked.bodies, sum(frames["miss"])))
    try:
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
    except ImportError as missing:
        print("Matplotlib is not installed (%s): no picture; the Debian package is python3-matplotlib" % missing)
        return 0
    figure, (times, levels) = pyplot.subplots(2, 1, sharex=True, figsize=(9, 6))
    times.stackplot(frames["frame"], [frames[stage + "_ms"] for stage in STAGES], labels=STAGES)
    times.axhline(asked.deadline_ms, color="black", linewidth=1, label="deadline")
    times.set_ylabel("ms")
    times.legend(loc="lower left", bbox_to_anchor=(0, 1), ncol=5, fontsize=8, frameon=False)
    columns = ["level_%d" % level for level in range(7) if sum(frames["level_%d" % level]) > 0]
    if columns:
        levels.stackplot(frames["frame"], [frames[column] for column in columns],
                         labels=[column.replace("_", " ") for column in columns])
        levels.legend(loc="upper left", fontsize=8)
    levels.set_xlabel("frame")
    levels.set_ylabel("contact pairs")
    figure.tight_layout()
    figure.savefig(asked.out, dpi=120)
    print("drawn into %s" % asked.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
