# SPDX-License-Identifier: MIT
"""Arrays of states: no copies, and how long they are valid."""
import gc
import weakref

import numpy
import pytest

import poise
from conftest import falling_ball, heap


def test_rows_are_the_states_of_the_bodies_in_order_of_slots():
    world = heap(20)
    for _ in range(30):
        world.step()
    states = world.states()
    assert len(states) == len(world) == 25
    assert states.position_m.shape == (25, 3) and states.orientation_wxyz.shape == (25, 4)
    assert states.position_m.dtype == numpy.float64 and states.slot.dtype == numpy.uint32
    for row, body in enumerate(world.bodies()):
        one = world.state(body)
        assert (states.slot[row], states.generation[row]) == (body.slot, body.generation)
        assert tuple(states.position_m[row]) == one.position_m
        assert tuple(states.orientation_wxyz[row]) == one.orientation_wxyz
        assert tuple(states.velocity_mps[row]) == one.velocity_mps
        assert tuple(states.angular_velocity_radps[row]) == one.angular_velocity_radps
    assert (numpy.diff(states.slot.astype(int)) > 0).all()


def test_arrays_show_one_memory_and_cannot_be_written_through():
    world, _ = falling_ball()
    states = world.states()
    array = states.position_m
    assert array.base is states and not array.flags.owndata and array.flags.c_contiguous
    assert numpy.shares_memory(array, states.position_m)
    assert not array.flags.writeable
    with pytest.raises(ValueError):
        array[0, 0] = 1
    with pytest.raises(ValueError):
        array.flags.writeable = True


def test_a_step_leaves_arrays_alone_and_the_next_states_fill_the_same_memory():
    world, ball = falling_ball()
    height = world.states().position_m[:, 2]
    before = height.copy()
    world.step()
    assert (height == before).all()
    again = world.states().position_m[:, 2]
    assert numpy.shares_memory(height, again) and (height == again).all() and height[1] < before[1]


def test_arrays_of_bodies_that_changed_stay_as_they_are():
    world, ball = falling_ball()
    array = world.states().position_m
    before = array.copy()
    world.remove_body(ball)
    world.step()
    fewer = world.states()
    assert len(fewer) == 1 and not numpy.shares_memory(array, fewer.position_m)
    # A body in the same slot is another one.
    world.add_body(poise.Shape.sphere(0.1), world.add_material(), position_m=(9, 9, 9))
    other = world.states()
    assert other.generation[1] == 1 and (array == before).all() and other.position_m[1, 0] == 9


def test_arrays_outlive_the_world_which_they_do_not_hold():
    world, _ = falling_ball()
    world.step()
    array, expected = world.states().velocity_mps, world.states().velocity_mps.copy()
    gone = weakref.ref(world)
    contacts = world.contacts()
    del world
    gc.collect()
    assert gone() is None, "no array keeps a World"
    garbage = [numpy.ones((2, 3)) for _ in range(1000)]
    assert (array == expected).all() and len(garbage) == 1000 and len(contacts) == 0


def test_the_world_of_a_scene_outlives_its_run():
    run = poise.SceneRun("two-body", threads=1)
    world = run.world
    del run
    gc.collect()
    assert world.step(poise.Budget.work(10)).frame == 0 and len(world.states()) == len(world)


def test_contacts_are_copies():
    world = heap(30)
    for _ in range(40):
        world.step()
    contacts = world.contacts()
    before = contacts.copy()
    for _ in range(5):
        world.step()
    assert len(contacts) > 5 and (contacts == before).all() and contacts.flags.writeable


def test_a_world_without_bodies_has_empty_arrays():
    assert poise.World(), "a World is true even without bodies"
    states = poise.World().states()
    assert states.position_m.shape == (0, 3) and states.slot.shape == (0,) and len(poise.World().contacts()) == 0
