#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A gaze experiment: the same heap under the same counted work, once for each side that the viewer looks at.

Prints the mean level at which contacts of either side were solved. The work is counted, so every run prints the same.
"""
import argparse
import sys

import numpy

import poise

SIDES = {"left": -1.8, "right": 1.8}


def whole(text):
    """A whole number above 0."""
    number = int(text)
    if number <= 0:
        raise ValueError
    return number


def heap(bodies):
    """Jacks above a tray of five planes."""
    world = poise.World(gravity_mps2=(0, 0, -9.81))
    material = world.add_material(restitution=0.2, friction=0.5)
    for normal in [(0, 0, 1), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)]:
        plane = poise.Shape.plane(normal, 0 if normal[2] else -2.5)
        world.add_body(plane, material, motion="static")
    arms = numpy.array([side * numpy.eye(3)[axis] for axis in range(3) for side in (-1, 1)])
    centers = numpy.concatenate([[(0, 0, 0)], 0.35 * arms, 0.68 * arms])
    jack = poise.Shape.spheres(centers, [0.28] + 6 * [0.22] + 6 * [0.18])
    row = numpy.arange(bodies)
    positions = numpy.stack([1.7 * (row % 3) - 1.7, 1.7 * (row // 3 % 3) - 1.7, 1 + 1.6 * (row // 9)], axis=1)
    half = 0.35 * row[:, None]
    turned = numpy.hstack([numpy.cos(half), numpy.sin(half) * numpy.array([[1, 2, 3]]) / numpy.sqrt(14)])
    world.add_bodies(jack, material, positions, orientation_wxyz=turned)
    return world


def levels_by_side(world, view, frames, budget):
    """Mean level of the contacts left and right of the middle, and how many there were."""
    levels = {side: [] for side in SIDES}
    for _ in range(frames):
        world.step(budget, view=view)
        contacts = world.contacts()
        x = contacts["point_m"][:, 0]
        levels["left"].append(contacts["level"][x < -0.6])
        levels["right"].append(contacts["level"][x > 0.6])
    return {side: numpy.concatenate(found) for side, found in levels.items()}


def main():
    parser = argparse.ArgumentParser(description="What a gaze does to the levels of contacts.")
    parser.add_argument("--bodies", type=whole, default=90)
    parser.add_argument("--frames", type=whole, default=120)
    parser.add_argument("--work", type=whole, default=40, help="node-pair expansions a frame (default: 40)")
    asked = parser.parse_args()
    print("gaze     contacts left   right   mean level left   right")
    means = {}
    for side, x in SIDES.items():
        view = poise.View((0, -8, 3), (0, 0, 1), gaze_at_m=(x, 0, 0.5))
        found = levels_by_side(heap(asked.bodies), view, asked.frames, poise.Budget.work(asked.work))
        means[side] = {other: float(levels.mean()) if len(levels) else 0.0 for other, levels in found.items()}
        print("%-5s    %13d   %5d   %15.3f   %5.3f" % (
            side, len(found["left"]), len(found["right"]), means[side]["left"], means[side]["right"]))
    gained = sum(means[side][side] - means[other][side] for side, other in (("left", "right"), ("right", "left"))) / 2
    print("a side that is looked at is solved %.3f levels deeper than when the other one is" % gained)
    return 0 if gained > 0 else 1


if __name__ == "__main__":
    sys.exit(main())
