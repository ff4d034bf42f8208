# SPDX-License-Identifier: MIT
"""Budgets, views, policies, and cues in Python."""
import time

import pytest

import poise
from conftest import falling_ball, heap


def mean_level(world, frames, budget, view=None, of=None):
    """The mean completed level of the contacts of bodies for whose user data `of` holds."""
    data = {body.slot: world.user_data(body) for body in world.bodies()}
    levels = []
    for _ in range(frames):
        world.step(budget, view=view)
        for contact in world.contacts():
            if of is None or of(max(data[contact["a"]], data[contact["b"]])):
                levels.append(contact["level"])
    return sum(levels) / len(levels)


def test_work_is_a_bound_and_less_of_it_refines_less():
    reports = {}
    for units in (0, 60, None):
        world = heap()
        budget = None if units is None else poise.Budget.work(units)
        reports[units] = [world.step(budget) for _ in range(50)]
    # One round of pairs is selected before the work is compared with the limit; without any, none is.
    assert sum(report.work_refine for report in reports[0]) == 0
    assert 0 < sum(report.work_refine for report in reports[60]) < sum(report.work_refine for report in reports[None])
    assert sum(report.pairs_left for report in reports[None]) == 0 < sum(report.pairs_left for report in reports[60])
    deep = [sum(report.level_2 for report in reports[units]) for units in (0, 60, None)]
    assert deep[0] <= deep[1] < deep[2]


def test_counted_work_gives_the_same_bits_on_any_number_of_threads():
    worlds = [heap(threads=threads, executor="threads") for threads in (1, 2, 3)]
    for _ in range(40):
        for world in worlds:
            world.step(poise.Budget.work(200))
    assert len({world.state_hash() for world in worlds}) == 1 and worlds[2].threads == 3


def test_a_deadline_in_the_past_leaves_only_what_must_be_done():
    world = heap()
    for _ in range(40):
        late = world.step(poise.Budget.until(time.monotonic() - 1))
    assert late.miss == 1 and late.lateness_ms > 0 and late.cause != "none" and late.budget_ms < 0
    assert late.jobs_done == 0
    assert world.step(poise.Budget.within(-1)).miss == 1
    roomy = world.step(poise.Budget.within(3600))
    assert roomy.miss == 0 and roomy.lateness_ms == 0 and roomy.cause == "none"
    assert roomy.budget_ms == pytest.approx(3.6e6, rel=1e-3), "counted from the start of the step, not of the Budget"


def test_the_report_has_the_columns_of_the_table_of_frames():
    world, _ = falling_ball()
    report = world.step(measure_energy=True, reference=True)
    row = report.as_dict()
    assert row["frame"] == report.frame == 0 and row["bodies"] == 1 and row["status"] == "done"
    assert isinstance(row["total_ms"], float) and row["total_ms"] >= row["predict_ms"] > 0
    assert row["time_s"] is None and row["kinetic_j"] == pytest.approx(world.conserved().kinetic_j)
    assert row["reference_converged"] == 1 and row["reference_e_rel"] is None
    assert "warm_up" not in row and set(row) <= set(dir(report))
    row["frame"] = 7
    assert report.frame == 0, "as_dict is a copy"


def test_what_the_viewer_looks_at_is_refined_first():
    levels = {}
    for side in (-2, 2):
        world = heap(90)
        view = poise.View((0, -9, 3), (0, 0, 1), gaze_at_m=(side, 0, 0.5))
        near, count = 0, 1e-9
        for _ in range(60):
            world.step(poise.Budget.work(30), view=view)
            for contact in world.contacts():
                if contact["point_m"][0] > 0.8:
                    near, count = near + contact["level"], count + 1
        levels[side] = near / count
    assert levels[2] > levels[-2] + 0.05


def test_a_cue_in_python_decides_what_is_refined():
    plain = heap()
    told = heap(policy=poise.Policy(cue=lambda pair: 1000.0 if 1 in pair.user_data else 1.0))
    budget = poise.Budget.work(60)
    heroes = mean_level(told, 60, budget, of=lambda data: data == 1) - mean_level(plain, 60, budget, of=lambda data: data == 1)
    assert heroes > 0.05
    assert plain.state_hash() != told.state_hash()


def test_a_cue_sees_the_pair_and_a_step_without_a_budget_asks_none():
    seen = []
    world = heap(policy=poise.Policy(cue=lambda pair: seen.append(pair) or 1))
    world.step()
    assert seen == []
    view = poise.View((0, -9, 3), (0, 0, 1))
    for _ in range(40):
        world.step(poise.Budget.work(500), view=view)
    assert seen and all(pair.has_view and 5 < pair.distance_m < 40 and len(pair.point_m) == 3 for pair in seen)
    assert {pair.user_data for pair in seen} >= {(0, 0), (0, 1)}
    assert any(pair.closing_mps > 0 for pair in seen) and all(0 <= pair.eccentricity_rad < 3.15 for pair in seen)


def test_a_policy_in_python_is_asked_and_its_order_is_followed():
    seen = []

    def deepest_first(frame, chain, cues):
        seen.append((frame.pairs, chain.level, len(chain.error_m), chain.error_m[0], cues.visibility))
        return 1.0 + chain.level

    # A rule of the library that does the same, for comparison, has the kind `deepest`; another order gives other bits.
    world = heap(policy=poise.Policy("custom", custom=deepest_first))
    first_in = heap(policy="fifo")
    for _ in range(40):
        world.step(poise.Budget.work(60))
        first_in.step(poise.Budget.work(60))
    assert seen and all(pairs >= 1 and level < levels and error > 0 and visibility == 1
                        for pairs, level, levels, error, visibility in seen)
    assert world.state_hash() != first_in.state_hash()
    with pytest.raises(poise.Error, match="custom"):
        heap(policy="custom")


def test_an_exception_of_a_cue_reaches_the_caller_of_the_step_which_is_done():
    def broken(pair):
        raise KeyError("no such thing")

    world = heap(policy=poise.Policy(cue=broken))
    frames = 0
    with pytest.raises(KeyError, match="no such thing"):
        for frames in range(60):
            world.step(poise.Budget.work(60))
    world.set_settings(policy=poise.Policy())
    assert world.step(poise.Budget.work(60)).frame == frames + 1
    wrong = heap(policy=poise.Policy(cue=lambda pair: "much"))
    with pytest.raises(TypeError):
        for _ in range(60):
            wrong.step(poise.Budget.work(60))


def test_a_cue_that_returns_nan_counts_as_one():
    nan = heap(policy=poise.Policy(cue=lambda pair: float("nan")))
    one = heap(policy=poise.Policy(cue=lambda pair: 1))
    for _ in range(40):
        nan.step(poise.Budget.work(60))
        one.step(poise.Budget.work(60))
    assert nan.state_hash() == one.state_hash()


def test_a_cue_cannot_use_the_world_that_asks_it():
    world = heap()
    world.set_settings(policy=poise.Policy(cue=lambda pair: len(world)))
    with pytest.raises(poise.Error, match="is being stepped"):
        for _ in range(60):
            world.step(poise.Budget.work(60))
    assert len(world) == 65
    # The function refers to the World that holds it: without this neither would ever be freed.
    world.set_settings(policy=poise.Policy())


def test_policies_are_values_with_the_fields_of_the_library():
    policy = poise.Policy(occlusion=1, quantum_units=100)
    assert policy.kind == "perceptual" and policy.occlusion == 1 and policy.quantum_units == 100 and policy.size == 1
    world = poise.World(policy=policy)
    policy.occlusion = 0.5
    assert world.settings.policy.occlusion == 1
    world.set_settings(policy="size", alpha=0.05)
    assert world.settings.policy.kind == "size" and world.settings.policy.occlusion == 1 and world.settings.alpha == 0.05


def test_the_hosts_own_work_is_kept_free():
    world = heap()
    for _ in range(30):
        kept = world.step(poise.Budget.within(10), host_work_s=0.5)
    assert kept.host_reserved_ms == 500
    for _ in range(30):
        world.report_host_work(0.25)
        learned = world.step(poise.Budget.within(10), host_work_s="learn")
    assert 100 < learned.host_reserved_ms < 1000
