# SPDX-License-Identifier: MIT
"""What the tests of the Python module share. ctest runs them with the built module in PYTHONPATH, and the command in POISE_COMMAND_PATH."""
import os

import numpy
import pytest

import poise

# A ball with six knobs: a tree with levels to refine.
KNOBS = numpy.array([(0, 0, 0), (0.5, 0, 0), (-0.5, 0, 0), (0, 0.5, 0), (0, -0.5, 0), (0, 0, 0.5), (0, 0, -0.5)])
KNOB_RADII = numpy.array([0.3, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2])


def knobs():
    return poise.Shape.spheres(numpy.concatenate([KNOBS, KNOBS * 1.4]), numpy.concatenate([KNOB_RADII, KNOB_RADII * 0.8]))


def falling_ball(**settings):
    """A World with a floor and a ball above it; returns both and the ball's BodyId."""
    world = poise.World(gravity_mps2=(0, 0, -9.81), **{"threads": 1, **settings})
    material = world.add_material(restitution=0.5, friction=0.6)
    world.add_body(poise.Shape.plane(), material, motion="static")
    ball = world.add_body(poise.Shape.sphere(0.5), material, position_m=(0, 0, 3))
    return world, ball


def heap(count=60, **settings):
    """A World in which `count` bodies with knobs fall into a tray; every fifth has the user data 1."""
    world = poise.World(gravity_mps2=(0, 0, -9.81), **{"threads": 1, **settings})
    material = world.add_material(restitution=0.2, friction=0.5)
    for normal, offset_m in [((0, 0, 1), 0), ((1, 0, 0), -2.5), ((-1, 0, 0), -2.5), ((0, 1, 0), -2.5), ((0, -1, 0), -2.5)]:
        world.add_body(poise.Shape.plane(normal, offset_m), material, motion="static")
    rows = numpy.arange(count)
    positions = numpy.stack([1.7 * (rows % 3) - 1.7, 1.7 * (rows // 3 % 3) - 1.7, 1.0 + 1.6 * (rows // 9)], axis=1)
    angles = 0.35 * rows
    axis = numpy.array([1, 2, 3]) / numpy.sqrt(14)
    turned = numpy.concatenate([numpy.cos(angles)[:, None], numpy.sin(angles)[:, None] * axis], axis=1)
    world.add_bodies(knobs(), material, positions, orientation_wxyz=turned, user_data=(rows % 5 == 0).astype(int))
    return world


@pytest.fixture
def command():
    """The path of the command poise."""
    path = os.environ.get("POISE_COMMAND_PATH", "")
    if not os.path.exists(path):
        pytest.skip("the command poise is not built")
    return path
