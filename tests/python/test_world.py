# SPDX-License-Identifier: MIT
"""Bodies, forces, contacts, queries."""
import math

import numpy
import pytest

import poise
from conftest import falling_ball, heap


def test_ball_falls_by_the_closed_form_and_comes_to_rest_on_the_floor():
    world, ball = falling_ball()
    for _ in range(10):
        world.step(dt_s=0.01)
    # v = g t, z = g t^2 / 2 after 0.1 s.
    assert world.state(ball).velocity_mps[2] == pytest.approx(-0.981, rel=1e-9)
    assert world.state(ball).position_m[2] == pytest.approx(3 - 9.81 * 0.005, rel=1e-9)
    for _ in range(400):
        world.step(poise.Budget.work(1000))
    assert world.state(ball).position_m[2] == pytest.approx(0.5, abs=0.01)


def test_bodies_come_and_go_and_a_handle_of_one_that_went_is_refused():
    world, ball = falling_ball()
    assert len(world) == 2 and ball in world and world.bodies()[1] == ball
    world.remove_body(ball)
    assert len(world) == 1 and ball not in world
    with pytest.raises(poise.Error) as refused:
        world.state(ball)
    assert refused.value.kind == "stale_handle"
    again = world.add_body(poise.Shape.sphere(0.1), world.add_material())
    assert again.slot == ball.slot and again != ball and len({again, ball, poise.BodyId(ball.slot, ball.generation)}) == 2


def test_setting_a_part_of_a_state_leaves_the_rest():
    world, ball = falling_ball()
    world.set_state(ball, velocity_mps=(1, 2, 3), angular_velocity_radps=numpy.array([0.1, 0.2, 0.3]))
    world.set_state(ball, position_m=[4, 5, 6])
    state = world.state(ball)
    assert state.position_m == (4, 5, 6) and state.velocity_mps == (1, 2, 3)
    assert state.angular_velocity_radps == pytest.approx((0.1, 0.2, 0.3)) and state.orientation_wxyz == (1, 0, 0, 0)


def test_forces_torques_and_impulses_change_momentum_as_they_should():
    world = poise.World()
    ball = world.add_body(poise.Shape.sphere(0.5), world.add_material(), mass_kg=2)
    assert world.mass_kg(ball) == 2 and world.motion(ball) == "dynamic" and not world.asleep(ball)
    world.apply_force(ball, (4, 0, 0), (0, 0, 0))
    world.apply_torque(ball, (0, 0, 1))
    world.step(dt_s=0.5)
    assert world.state(ball).velocity_mps == pytest.approx((1, 0, 0))
    inertia = 0.4 * 2 * 0.25
    assert world.state(ball).angular_velocity_radps == pytest.approx((0, 0, 0.5 / inertia))
    world.apply_impulse(ball, (0, 2, 0), world.state(ball).position_m)
    assert world.state(ball).velocity_mps == pytest.approx((1, 1, 0))
    assert world.conserved().momentum_ns == pytest.approx((2, 2, 0))
    assert world.conserved().kinetic_j == pytest.approx(2 + 0.5 * inertia * (0.5 / inertia) ** 2)


def test_bodies_added_as_arrays_are_those_added_one_by_one():
    positions = numpy.array([[0, 0, 1], [2, 0, 1.5], [4, 0, 2]])
    spins = numpy.array([[0, 0, 1.0], [0, 1, 0], [1, 0, 0]], dtype=numpy.float32)
    hashes = []
    for as_arrays in (True, False):
        world = poise.World(gravity_mps2=(0, 0, -1), threads=1)
        material, shape = world.add_material(), poise.Shape.sphere(0.5)
        if as_arrays:
            ids = world.add_bodies(shape, material, positions, angular_velocity_radps=spins, user_data=[7, 8, 9])
        else:
            ids = [world.add_body(shape, material, position_m=p, angular_velocity_radps=w, user_data=7 + i)
                   for i, (p, w) in enumerate(zip(positions, spins))]
        assert [world.user_data(body) for body in ids] == [7, 8, 9]
        world.step()
        hashes.append(world.state_hash())
    assert hashes[0] == hashes[1]


def test_contacts_carry_the_weight_of_a_resting_ball():
    world, ball = falling_ball()
    world.set_state(ball, position_m=(0, 0, 0.5))
    events = []
    for _ in range(120):
        world.step(dt_s=0.01)
        events += [(event.kind, event.b) for event in world.contact_events()]
    assert events[0] == ("begin", ball)
    contacts = world.contacts()
    assert len(contacts) == 1 and contacts["b"][0] == ball.slot and contacts["a"][0] == 0
    assert contacts["normal"][0] == pytest.approx([0, 0, 1]) and contacts["impulse_ns"].shape == (1, 3)
    assert contacts["impulse_ns"][0, 2] == pytest.approx(world.mass_kg(ball) * 9.81 * 0.01, rel=0.02)
    points = world.contact_points()
    assert len(points) == contacts["point_count"][0] and points["contact"].max() == 0
    assert points["impulse_ns"].sum(axis=0) == pytest.approx(contacts["impulse_ns"][0])
    world.set_state(ball, position_m=(0, 0, 5))
    world.step()
    assert [event.kind for event in world.contact_events()] == ["end"] and len(world.contacts()) == 0


def test_slots_of_contacts_find_the_rows_of_states():
    world = heap()
    for _ in range(40):
        world.step()
    states, contacts = world.states(), world.contacts()
    assert len(contacts) > 10
    rows = numpy.searchsorted(states.slot, contacts["b"])
    assert (states.slot[rows] == contacts["b"]).all()
    # A contact point is within the bounding radius of its bodies, and a little of motion.
    far = numpy.linalg.norm(states.position_m[rows] - contacts["point_m"], axis=1)
    assert far.max() < 1.3


def test_queries_answer_on_true_surfaces():
    world, ball = falling_ball()
    hit = world.cast_ray((0, 0, 10), (0, 0, -2))
    assert hit.body == ball and hit.distance_m == pytest.approx(6.5) and hit.normal == pytest.approx((0, 0, 1))
    assert world.cast_ray((0, 0, 10), (0, 0, -1), ignore=ball).distance_m == pytest.approx(10)
    assert world.cast_ray((0, 0, 10), (0, 0, 1)) is None
    assert world.cast_sphere((0, 0, 10), 0.5, (0, 0, -1)).distance_m == pytest.approx(6)
    assert world.overlap_sphere((0, 0, 3.9), 0.5) == [ball] and world.overlap_sphere((5, 0, 3), 0.5) == []
    assert world.overlap_box((0, 0, 3), (0.1, 0.1, 0.1)) == [ball]
    near = world.closest_point((0, 0, 5))
    assert near.body == ball and near.distance_m == pytest.approx(1.5)
    assert world.closest_point((0, 0, 3), body=ball).distance_m == pytest.approx(-0.5)


def test_a_filter_lets_pairs_pass_through_each_other():
    world, ball = falling_ball()
    asked = []
    world.set_pair_filter(lambda a, b, data_a, data_b: asked.append((a, b)) or ball not in (a, b))
    for _ in range(200):
        world.step(dt_s=0.01)
    assert world.state(ball).position_m[2] < -10 and ball in asked[0]
    world.set_pair_filter(None)
    world.set_state(ball, position_m=(0, 0, 1), velocity_mps=(0, 0, 0))
    for _ in range(100):
        world.step(dt_s=0.01)
    assert world.state(ball).position_m[2] > 0.45


def test_shapes_know_their_mass_properties(tmp_path):
    assert poise.Shape.sphere(2).volume_m3 == pytest.approx(32 / 3 * math.pi)
    box = poise.Shape.box((1, 2, 3), depth=1, tree_cache=tmp_path)
    assert box.volume_m3 == pytest.approx(48) and box.kind == "tree" and box.note == ""
    assert len(list(tmp_path.iterdir())) > 0, "the tree was to be cached here"
    corners = numpy.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    wedge = poise.Shape.mesh(corners, faces, depth=2, tree_cache=False)
    assert wedge.volume_m3 == pytest.approx(1 / 6) and wedge.origin_offset_m == pytest.approx((0.25, 0.25, 0.25))
    file = tmp_path / "wedge.obj"
    file.write_text("".join("v %g %g %g\n" % tuple(v) for v in corners) +
                    "".join("f %d %d %d\n" % (a + 1, b + 1, c + 1) for a, b, c in faces))
    read = poise.Shape.from_file(file, scale=2, depth=2, tree_cache=False)
    assert read.volume_m3 == pytest.approx(8 / 6) and read.depth == 2
    centers, radii = read.spheres_at(1)
    assert centers.shape == (len(radii), 3) and 1 < len(radii) <= 8
    assert len(read.spheres_at(2)[1]) > len(radii)
    assert poise.Shape.plane().kind == "plane" and len(poise.Shape.plane().spheres_at(0)[1]) == 0
