# SPDX-License-Identifier: MIT
"""`poise tune`: searches the weights of a policy. The command starts this program with its own path as --poise."""
import datetime
import json
import os
import shlex
import signal
import sys
import tempfile

import cue_worth
import fields
import rivals
import options as command_line
import scenes as scenes_of
import served
from options import BAD_INPUT, BAD_USAGE, Refused

OUTPUT_FAILED = 4
STOPPED = 130
TERMINATED = 143


class Terminated(KeyboardInterrupt):
    """SIGTERM, which ends what Ctrl-C ends."""


def terminate(signal_number, frame):
    signal.signal(signal_number, signal.SIG_DFL)
    raise Terminated


def check_output(path):
    """Tells a file that cannot be written before long work."""
    if command_line.is_special(path):
        return
    folder = os.path.dirname(os.path.realpath(path))
    if not os.path.isdir(folder) or not os.access(folder, os.W_OK):
        raise Refused(f"{path}: cannot be written", OUTPUT_FAILED)


def write(path, document):
    """By a temporary file and its renaming: there is never half a file. Links are followed, and a pipe or a device is
    written to."""
    target = os.path.realpath(path)
    part = path if command_line.is_special(path) else f"{target}.part{os.getpid()}"
    try:
        with open(part, "w", encoding="utf-8") as file:
            json.dump(document, file, indent=2)
            file.write("\n")
        if part != path:
            os.replace(part, target)
    except OSError as failure:
        if part != path and os.path.exists(part):
            os.remove(part)
        raise Refused(f"{path}: {failure.strerror}", OUTPUT_FAILED) from failure


def tell(text):
    """Writes a table to the standard output."""
    try:
        print(text, end="", flush=True)
    except OSError as failure:
        # What is left in the buffer could not be written at the end either.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise Refused(f"standard output: {failure.strerror}", OUTPUT_FAILED) from failure


def observer_of(base):
    """The policy of the runs that make the states: the base, which also observes what other cues ask for. What poise
    refuses in the base it refuses here: it stays as it is."""
    policy = dict(fields.OBSERVED)
    for name, value in base.items():
        number = isinstance(value, (int, float)) and not isinstance(value, bool)
        policy[name] = max(value, fields.OBSERVED[name]) if name in fields.OBSERVED and number and value >= 0 else value
    return {"schema": "poise.policy/1", "name": "observer", "policy": policy}


class Work:
    """What a command needs while it runs: folder, runs that are to be ended, and how it was called."""

    def __init__(self, options, folder):
        self.options, self.folder = options, folder
        self.base = command_line.read_base(options.base)
        self.scenes = None
        self._groups = []
        self._observer = os.path.join(folder, "observer.json")
        with open(self._observer, "w", encoding="utf-8") as file:
            json.dump(observer_of(self.base), file)
        self._compare = ["--budgets", options.budgets, "--from", options.budget_from, "--from-policy", self._observer,
                         "--frames", str(options.frames), "--every", str(options.every), "--warmup",
                         str(options.warmup), "--history", str(options.history)]
        self._compare += ["--bodies", str(options.bodies)] if options.bodies else []
        self._compare += ["--polygons"] if options.polygons else []

    def say(self, text):
        if not self.options.quiet:
            print("poise tune: " + text, file=sys.stderr, flush=True)

    def look_at_scenes(self):
        """Before any work: refuses scenes and seeds that make no sense together."""
        self.scenes = scenes_of.Scenes(self.options)

    def runs(self, scenes, seeds):
        """Runs whose states are made."""
        for scene in self.scenes.without_generators(scenes):
            self.say(f"{scene} has no generators: seeds move nothing in it, and one is enough")
        runs = served.Runs([served.Run(self.options.poise, scene, seed, self._compare)
                            for scene, seed in self.scenes.runs(scenes, seeds)], self.options.jobs,
                           tempfile.mkdtemp(dir=self.folder))
        self._groups.append(runs)
        self.say(f"making the states of {len(runs.runs)} runs")
        try:
            runs.start()
        except served.RunFailed as failed:
            # The file that the user knows: what is wrong in the observer is wrong in the base.
            raise served.RunFailed(str(failed).replace(self._observer, self.options.base or "policy"),
                                   failed.code) from failed
        self.scenes.check_unchanged(runs.runs)
        return runs

    def end(self):
        for group in self._groups:
            group.end()

    def facts(self, runs):
        """What the figures were made with."""
        some = runs.runs[0].facts
        o = self.options
        return {"schema": "poise.tune/1", "command": "poise tune " + shlex.join(self.words), "date":
                datetime.date.today().isoformat(), "machine": some["machine"], "build": some["build"],
                "budgets": some["budgets"], "budget_unit": some["budget_unit"], "from": o.budget_from,
                "every": o.every, "warmup": o.warmup, "history": o.history, "polygons": o.polygons,
                "objective": "mean over runs and budgets of log(E_seen / E_seen of the base policy)"}


def measure_cues(work):
    o = work.options
    work.look_at_scenes()
    runs = work.runs(o.scenes, o.seeds)
    rows = cue_worth.measure(runs, work.base, o.seed, work.say)
    write(o.out, {**work.facts(runs), "schema": "poise.cues/1", "policy": work.base, "runs": [
        {"scene": run.scene, "seed": run.seed, "bodies": run.facts["bodies"], "states": run.facts["states"]}
        for run in runs.runs], "cues": rows})
    if not o.quiet:
        tell(cue_worth.table(rows))


def measure_base(work):
    o = work.options
    work.look_at_scenes()
    runs = work.runs(o.scenes, o.seeds)
    group = rivals.measure(runs, work.base, rivals.rivals_of(o, work.base, False), o.seed, work.say)
    facts = work.facts(runs)
    write(o.out, {**facts, "schema": "poise.rivals/1", "policy": work.base, "against_rivals": group})
    if not o.quiet:
        tell(rivals.table("base policy", group, facts["budgets"], facts["budget_unit"]))


def tune(work, journal):
    try:
        import optuna
    except ImportError as missing:
        raise Refused(f"Optuna is missing in {sys.executable}: install the Debian package python3-optuna, or name a "
                      "Python that has it in POISE_PYTHON") from missing
    import search
    import workers
    o = work.options
    if o.ends_with_input:
        workers.end_with_input()
    work.look_at_scenes()
    runs = work.runs(o.scenes, o.seeds)
    setup = {"scenes": o.scenes, "seeds": o.seeds, "budgets": o.budgets, "from": o.budget_from, "frames": o.frames,
             "every": o.every, "warmup": o.warmup, "history": o.history, "bodies": o.bodies, "polygons": o.polygons,
             "base": work.base, "search": o.search,
             "scene_hashes": {scene: work.scenes.hash_of(scene) for scene in o.scenes},
             "program": runs.runs[0].facts["program"]}
    try:
        study = search.Study(optuna, journal, setup, o.search)
    except search.WrongJournal as wrong:
        raise Refused(str(wrong)) from wrong
    try:
        if o.task is not None or (o.engine == "local" and o.workers == 1):
            study.work(runs, work.base, o.trials, o.seed, work.say)
        elif o.engine == "slurm":
            workers.run_slurm(study, o, work.words, journal + ".workers/slurm", work.say)
        else:
            workers.run_local(study, o, work.words, work.say)
        done, failed = study.finished()
        policy = study.best()
    finally:
        study.leave()
    if o.task is not None:
        return
    if policy is None:
        raise Refused(f"none of {len(failed)} trials succeeded", BAD_INPUT)
    write_policy(work, runs, policy, {"done": len(done), "failed": len(failed)})


def write_policy(work, runs, policy, trials):
    """Measures the policy where it was searched and elsewhere, and writes it with what came of that."""
    o = work.options
    facts = work.facts(runs)
    others = rivals.rivals_of(o, work.base, True)
    fixed = work.scenes.without_generators(o.scenes)
    evidence = {**facts, "trials": trials, "search": o.search, "without_generators": [
        *fixed, *work.scenes.without_generators(o.holdout)], "tuning": rivals.measure(
            runs, policy, others, o.seed, work.say)}
    tables = [rivals.table("searched on", evidence["tuning"], facts["budgets"], facts["budget_unit"])]
    groups = [("held_out_seeds", "held-out seeds of the same scenes", work.scenes.with_generators(o.scenes)),
              ("held_out_scenes", "held-out scenes", o.holdout)]
    for name, title, scenes in groups:
        if not scenes:
            continue
        held_out = work.runs(scenes, o.holdout_seeds)
        evidence[name] = rivals.measure(held_out, policy, others, o.seed, work.say)
        tables.append(rivals.table(title, evidence[name], facts["budgets"], facts["budget_unit"]))
    if fixed:
        tables.append(f"Not among held-out seeds, since seeds move nothing without generators: {', '.join(fixed)}\n")
    name = o.name or os.path.basename(o.out).removesuffix(".json")
    write(o.out, {"schema": "poise.policy/1", "name": name, "policy": policy, "evidence": evidence})
    if not o.quiet:
        tell("\n".join(tables))


def what_is_left(options):
    """Of a command that was stopped."""
    if options is None or options.cues or options.measure:
        return "nothing is kept, and the same command begins again"
    return "what was done is in the journal, and the same command goes on"


def main(words):
    signal.signal(signal.SIGTERM, terminate)
    options = None
    try:
        options = command_line.parser().parse_args(words)
        journal = command_line.check(options)
        check_output(options.out)
        check_output(journal)
        with tempfile.TemporaryDirectory(prefix="poise-tune-") as folder:
            work = Work(options, folder)
            work.words = words[words.index("--poise") + 2:] if "--poise" in words else words
            try:
                if options.cues:
                    measure_cues(work)
                elif options.measure:
                    measure_base(work)
                else:
                    tune(work, journal)
            finally:
                work.end()
    except Refused as refused:
        print(f"poise tune: {refused}", file=sys.stderr)
        return refused.code
    except (served.RunFailed, served.PolicyRefused) as failed:
        print(f"poise tune: {failed}", file=sys.stderr)
        return failed.code if getattr(failed, "code", 0) in (BAD_USAGE, BAD_INPUT) else BAD_INPUT
    except KeyboardInterrupt as stopped:
        # The one who started a worker says it for all.
        if "--task" not in words:
            print(f"poise tune: stopped; {what_is_left(options)}", file=sys.stderr)
        return TERMINATED if isinstance(stopped, Terminated) else STOPPED
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
