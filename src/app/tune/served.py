# SPDX-License-Identifier: MIT
"""States of a scene that `poise compare --serve` has made and steps by the policies that it is asked for."""
import concurrent.futures
import json
import os
import subprocess

from options import BAD_INPUT, Refused


class RunFailed(Exception):
    """A run could not be made or ended before its answer; `code` is its exit code."""

    def __init__(self, message, code):
        super().__init__(message)
        self.code = code


class PolicyRefused(Exception):
    """A run lives and has refused a policy."""


class Run:
    """One scene and seed. Not for several threads at once."""

    def __init__(self, poise, scene, seed, options):
        self.scene, self.seed = scene, seed
        self.facts = {}
        self._command = [poise, "compare", scene, "--seed", str(seed), *options, "--threads", "1", "--quiet", "--serve"]
        self._child = None

    def start(self):
        """Makes the states, unless they are there. Refused: what they are of has changed since they were made first."""
        if self._child is not None and self._child.poll() is None:
            return
        # A session of its own, so that Ctrl-C is for the search alone, which then ends its runs.
        self._child = subprocess.Popen(self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                       stderr=subprocess.PIPE, text=True, start_new_session=True)
        facts = self._read()
        if self.facts and any(facts[name] != self.facts[name] for name in ("scene_hash", "program")):
            self.end()
            raise Refused(f"{self.scene}: it or the program has changed since its states were made first", BAD_INPUT)
        self.facts = facts

    def ask(self, policy):
        """E_seen of each state and budget under a policy: its name, or a file."""
        self.start()
        try:
            self._child.stdin.write(policy + "\n")
            self._child.stdin.flush()
        except BrokenPipeError:
            pass  # _read says why it has ended
        answer = self._read()
        if "error" in answer:
            raise PolicyRefused(f"{self.scene}, seed {self.seed}: {answer['error']}")
        return answer["E_seen"]

    def _read(self):
        child = self._child
        line = child.stdout.readline()
        if line:
            return json.loads(line)
        code = child.wait()
        said = child.stderr.read().strip().splitlines()
        self._child = None
        text = said[0] if said else f"poise compare {self.scene} ended with {code}"
        raise RunFailed(text.removeprefix("poise compare: "), code)

    def end(self):
        child, self._child = self._child, None
        if child is not None:
            child.kill()
            child.wait()


class Runs:
    """Several runs, `jobs` of which work at a time. Policies are files of a folder, made once for each text."""

    def __init__(self, runs, jobs, folder):
        self.runs = runs
        self._pool = concurrent.futures.ThreadPoolExecutor(max_workers=jobs)
        self._folder = folder
        self._answers = {}

    def _all(self, task):
        futures = [self._pool.submit(task, run) for run in self.runs]
        concurrent.futures.wait(futures)
        return [future.result() for future in futures]

    def start(self):
        self._all(Run.start)

    def ask(self, policy, name="trial"):
        """E_seen of each run, state and budget under a policy: what a policy file may say, or a name."""
        key = json.dumps(policy, sort_keys=True)
        if key not in self._answers:
            word = policy
            if not isinstance(policy, str):
                word = os.path.join(self._folder, f"{len(os.listdir(self._folder))}.json")
                with open(word, "w", encoding="utf-8") as file:
                    json.dump({"schema": "poise.policy/1", "name": name, "policy": policy}, file)
            self._answers[key] = self._all(lambda run: run.ask(word))
        return self._answers[key]

    def end(self):
        self._pool.shutdown(wait=False, cancel_futures=True)
        for run in self.runs:
            run.end()
        self._pool.shutdown()
