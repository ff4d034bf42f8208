# SPDX-License-Identifier: MIT
"""Poise: scenes of many rigid bodies, stepped inside a time budget.

    import poise

    world = poise.World(gravity_mps2=(0, 0, -9.81))
    rubber = world.add_material(restitution=0.5, friction=0.6)
    world.add_body(poise.Shape.plane((0, 0, 1)), rubber, motion="static")
    ball = world.add_body(poise.Shape.sphere(0.5), rubber, position_m=(0, 0, 3))
    for frame in range(180):
        report = world.step(poise.Budget.within(0.004))
    print(world.state(ball).position_m, report.total_ms)

Each step refines the collisions that a viewer would notice most, until its budget is spent: a deadline, counted
work, or none. docs/python.md is the guide; docs/my-engine.md explains a frame.

Names carry units: _m metres, _kg kilograms, _s seconds, _ms milliseconds, _mps metres a second, _radps radians a
second, _n newtons, _nm newton metres, _ns newton seconds (kg m/s, not nanoseconds), _j joules. Vectors are any
three numbers, quaternions any four, w first. The world frame is right-handed. A call with bad arguments raises
poise.Error, which has the library's message with field, value and rule; a value of a wrong type raises TypeError.

Threads: a step releases the global lock, so other Python threads run meanwhile; they must leave this World alone
until the step has returned (poise.Error otherwise). Several Worlds may step at once.
"""
from . import _needs  # first: what it says is clearer than what the compiled part would say
from . import _at_exit, results
from ._core import (
    BodyId,
    BodyState,
    Budget,
    ClosestPoint,
    Conserved,
    ContactEvent,
    FrameFacts,
    FrameReport,
    MaterialId,
    PairChain,
    PairCues,
    PairView,
    Policy,
    RayHit,
    Replay,
    SceneBody,
    SceneRun,
    Settings,
    Shape,
    SphereCastHit,
    States,
    View,
    World,
    __version__,
    commit,
)
from ._errors import Error
from ._scenes import shipped_scenes
from .results import frames_table, read_run, read_sweep, read_table, runs_table

__all__ = [
    "World", "Settings", "Shape", "BodyId", "BodyState", "MaterialId", "States", "Conserved", "ContactEvent",
    "Budget", "View", "FrameReport", "Policy", "PairView", "PairChain", "PairCues", "FrameFacts",
    "RayHit", "SphereCastHit", "ClosestPoint", "SceneRun", "SceneBody", "Replay", "shipped_scenes",
    "Error", "results", "frames_table", "read_run", "read_sweep", "read_table", "runs_table",
    "commit",
]
