# SPDX-License-Identifier: MIT
"""The global lock and Worlds in use. No test here depends on how fast anything is."""
import os
import subprocess
import sys
import threading
import time

import pytest

import poise
from conftest import heap


@pytest.fixture
def no_forced_switches():
    """A Python thread gets the lock only where another one gives it back by itself."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e6)
    yield
    sys.setswitchinterval(before)


def test_another_thread_makes_progress_while_a_world_steps(no_forced_switches):
    world = heap(40)
    counted, stop, begun = [0], threading.Event(), threading.Event()

    def count():
        begun.set()
        while not stop.is_set():
            counted[0] += 1
            time.sleep(0)  # gives the lock back

    counter = threading.Thread(target=count)
    counter.start()
    begun.wait()
    progress = False
    # Between these lines nothing but a step gives the lock back; how many steps it takes is for the system to say.
    for _ in range(20000):
        before = counted[0]
        world.step(poise.Budget.work(50))
        if counted[0] != before:
            progress = True
            break
    stop.set()
    counter.join()
    assert progress, "no step gave the global lock back"


def test_a_world_that_is_being_stepped_refuses_other_threads():
    inside, leave = threading.Event(), threading.Event()

    def cue(pair):
        inside.set()
        leave.wait()
        return 1

    world = heap(policy=poise.Policy(cue=cue))
    failures = []

    def steps():
        try:
            while not inside.is_set():
                world.step(poise.Budget.work(60))
        except BaseException as failure:  # the test tells it
            failures.append(failure)

    stepper = threading.Thread(target=steps)
    stepper.start()
    inside.wait()
    for call in (world.states, world.bodies, world.step, lambda: len(world), lambda: world.settings):
        with pytest.raises(poise.Error, match="is being stepped"):
            call()
    leave.set()
    stepper.join()
    assert failures == [] and len(world) == 65


def test_worlds_of_several_threads_step_at_once_with_the_same_result():
    expected = heap(30)
    worlds = [heap(30) for _ in range(4)]

    def steps(world):
        for _ in range(20):
            world.step(poise.Budget.work(100))

    threads = [threading.Thread(target=steps, args=(world,)) for world in worlds]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    steps(expected)
    assert {world.state_hash() for world in worlds} == {expected.state_hash()}


def test_a_daemon_thread_that_steps_does_not_end_the_program_badly(tmp_path):
    program = tmp_path / "program.py"
    program.write_text(
        "import sys, threading, poise\n"
        "sys.path.insert(0, %r)\n"
        "from conftest import heap\n"
        "world, stepped = heap(policy=poise.Policy(cue=lambda pair: 1)), threading.Event()\n"
        "def steps():\n"
        "    while True:\n"
        "        world.step(poise.Budget.work(100))\n"
        "        stepped.set()\n"
        "threading.Thread(target=steps, daemon=True).start()\n"
        "stepped.wait()\n"
        "print('end')\n" % os.path.dirname(os.path.abspath(__file__)))
    # Where it ends badly it does so nearly always; three times leave little to chance.
    for _ in range(3):
        done = subprocess.run([sys.executable, "-B", program], capture_output=True, text=True)
        assert (done.returncode, done.stdout) == (0, "end\n"), done.stderr


def test_a_policy_that_is_slow_on_another_thread_stops_nobody_under_a_deadline(tmp_path):
    """Its frame does not wait for a thread that is held up in the policy, and what follows waits for that thread."""
    program = tmp_path / "program.py"
    program.write_text(
        "import sys, threading, time, poise\n"
        "sys.path.insert(0, %r)\n"
        "from conftest import heap\n"
        "main = threading.get_ident()\n"
        "def policy(frame, chain, cues):\n"
        "    if threading.get_ident() != main:\n"
        "        time.sleep(0.02)\n"
        "    return 1.0\n"
        "world = heap(policy=poise.Policy('custom', custom=policy), threads=2)\n"
        "body = world.bodies()[-1]\n"
        "for frame in range(60):\n"
        "    world.step(poise.Budget.within(0.004))\n"
        "    world.set_user_data(body, frame)\n"
        "print('end')\n" % os.path.dirname(os.path.abspath(__file__)))
    done = subprocess.run([sys.executable, "-B", program], capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stdout) == (0, "end\n"), done.stderr


def test_a_cue_on_several_threads_gives_the_bits_of_one():
    callers, lock = set(), threading.Lock()

    def cue(pair):
        with lock:
            callers.add(threading.get_ident())
        return 1

    world = heap(policy=poise.Policy(cue=cue), threads=3, executor="threads")
    alone = heap(policy=poise.Policy(cue=lambda pair: 1))
    for _ in range(40):
        world.step(poise.Budget.work(200))
        alone.step(poise.Budget.work(200))
    # How many threads came to it is for the system to say.
    assert callers
    assert world.state_hash() == alone.state_hash()
