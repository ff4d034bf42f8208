# SPDX-License-Identifier: MIT
"""What `poise check` says of the scenes before any state is made: which are the same, and whether seeds move them."""
import json
import subprocess

import served
from options import BAD_INPUT, Refused


def _facts(poise, scene, bodies):
    # In a session of its own, as runs are: Ctrl-C is for the search alone.
    said = subprocess.run([poise, "check", scene, *bodies, "--json", "-", "--quiet"], stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False, text=True,
                          start_new_session=True)
    if said.returncode != 0:
        lines = said.stderr.strip().splitlines()
        text = lines[0] if lines else f"poise check {scene} ended with {said.returncode}"
        raise served.RunFailed(text.removeprefix("poise check: "), said.returncode)
    return json.loads(said.stdout)


class Scenes:
    """The scenes of a command, by the names that it gives them."""

    def __init__(self, options):
        """Refused: a scene that cannot run, one that is given twice under different names, and seeds that move
        nothing."""
        self._searches = not (options.cues or options.measure)
        holdout = options.holdout if self._searches else []
        bodies = ["--bodies", str(options.bodies)] if options.bodies else []
        self._facts = {scene: _facts(options.poise, scene, bodies) for scene in (*options.scenes, *holdout)}
        self._check_same(options.scenes, holdout)
        self._check_seeds(options, holdout)

    def _check_same(self, searched, holdout):
        seen = {}
        for name, group in (("SCENE", searched), ("--holdout", holdout)):
            for scene in group:
                same = seen.setdefault(self.hash_of(scene), scene)
                if same != scene:
                    raise Refused(f"{name}: {scene} is the same scene as {same}")

    def _check_seeds(self, options, holdout):
        given = [("--seeds", options.seeds, options.scenes)] if options.seeds_given else []
        if options.holdout_seeds_given and self._searches:
            given.append(("--holdout-seeds", options.holdout_seeds, [*options.scenes, *holdout]))
            if not holdout and not self.with_generators(options.scenes):
                raise Refused(f"--holdout-seeds: {options.scenes[0]} has no generators: seeds move nothing in it, and "
                              "its states are those that are searched on")
        for option, seeds, scenes in given:
            for scene in self.without_generators(scenes):
                if len(seeds) > 1:
                    raise Refused(f"{option}: {scene} has no generators: seeds move nothing in it, must be one seed")

    def hash_of(self, scene):
        """Of its text and of the files that it names."""
        return self._facts[scene]["scene_hash"]

    def with_generators(self, scenes):
        return [scene for scene in scenes if self._facts[scene]["generators"]]

    def without_generators(self, scenes):
        return [scene for scene in scenes if not self._facts[scene]["generators"]]

    def runs(self, scenes, seeds):
        """A scene and a seed for each run: only the first seed where seeds move nothing."""
        return [(scene, seed) for scene in scenes
                for seed in (seeds if self._facts[scene]["generators"] else seeds[:1])]

    def check_unchanged(self, runs):
        """Refuses states of another text or other files than those that were looked at first."""
        for run in runs:
            if run.facts["scene_hash"] != self.hash_of(run.scene):
                raise Refused(f"{run.scene}: has changed since this command began", BAD_INPUT)
