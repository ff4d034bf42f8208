# SPDX-License-Identifier: MIT
"""The search: an Optuna study in a journal that several processes and machines may work on."""
import json
import time
import warnings

import fields
import figures
import journal as study_file
import served

# A trial whose worker died so often is not tried again: it may be what kills them.
MOST_LOSSES = 3
# Between two looks at the trials of others.
WAIT_S = 0.3


class WrongJournal(Exception):
    """The journal cannot be read, or holds a study of something else."""


def _difference(name, known, value):
    """What of a study's setup is not that of the command."""
    if name not in known:
        return f"its study does not say its {name}: an earlier version has made it"
    if name == "scene_hashes":
        changed = [scene for scene in value if known[name].get(scene) != value[scene]]
        return f"the scene {', '.join(changed)}, or a file that it names, has changed since its study was made"
    return f"its study has {name} = {json.dumps(known[name])}, not {json.dumps(value)}"


class Study:
    """A study and this process as one of its workers. Ends exactly at the number of trials that is asked for, however
    many workers there are: a worker begins a trial only while those that are finished and those that run elsewhere
    are fewer."""

    def __init__(self, optuna, journal, setup, searched):
        """Makes the study if it is not there. Refused: a journal of another setup."""
        self._optuna = optuna
        self._searched = searched
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        warnings.simplefilter("ignore")
        try:
            self._workers = study_file.Workers(journal)
        except OSError as failure:
            raise WrongJournal(f"--journal {journal}: {failure}") from failure
        try:
            with self._workers.alone():
                self._storage = optuna.storages.JournalStorage(
                    study_file.backend(optuna, journal, self._workers.folder))
                self.study = optuna.create_study(study_name="poise", storage=self._storage, load_if_exists=True,
                                                 direction="minimize", sampler=optuna.samplers.RandomSampler())
                self._check(journal, setup)
        except (OSError, ValueError, KeyError) as failure:
            self.leave()
            raise WrongJournal(f"--journal {journal}: {failure}") from failure
        except WrongJournal:
            self.leave()
            raise

    def _check(self, journal, setup):
        known = self.study.user_attrs.get("setup")
        if known is None:
            self.study.set_user_attr("setup", setup)
            return
        for name, value in setup.items():
            if name not in known or known[name] != value:
                raise WrongJournal(f"--journal {journal}: {_difference(name, known, value)}; name another file, or "
                                   "remove this one")

    def leave(self):
        self._workers.leave()

    def finished(self):
        """The trials that are done, and those that failed, but for those that were stopped."""
        states = self._optuna.trial.TrialState
        trials = self.study.get_trials(deepcopy=False)
        done = [t for t in trials if t.state == states.COMPLETE]
        failed = [t for t in trials if t.state == states.FAIL and not t.user_attrs.get("stopped")]
        return done, failed

    def best(self):
        """The policy of the best trial; None where none is done."""
        done, _ = self.finished()
        return min(done, key=lambda t: (t.value, t.number)).user_attrs["policy"] if done else None

    def begin(self, base):
        """What is known to be sensible is tried first: the base, the weights of the measure, and the base with one cue
        more."""
        shipped = {**fields.SHIPPED, **base}
        more = [{**shipped, cue: 1} for cue in fields.CUES if cue in self._searched and shipped[cue] == 0]
        with self._workers.alone():
            for first in (shipped, {**shipped, **fields.LIKE_THE_MEASURE}, *more):
                values = {name: first[name] for name in self._searched}
                if all(value in fields.CHOICES[name] for name, value in values.items()):
                    self.study.enqueue_trial(values, skip_if_exists=True)

    def _abandon(self, trial, lost):
        """Ends a trial that has no value, so that its parameters are tried again."""
        values = trial.system_attrs.get("fixed_params") or trial.params
        losses = trial.user_attrs.get("losses", 0) + lost
        # By its identifier, since it may be another's.
        identifier = trial._trial_id  # pylint: disable=protected-access
        if losses >= MOST_LOSSES:
            self._storage.set_trial_user_attr(identifier, "error", f"{losses} workers ended during this trial")
        else:
            self._storage.set_trial_user_attr(identifier, "stopped", True)
            if set(values) == set(self._searched):
                self.study.enqueue_trial(values, user_attrs={"losses": losses})
        self._storage.set_trial_state_values(identifier, state=self._optuna.trial.TrialState.FAIL)

    def _abandon_lost(self, trials, say):
        """Those whose workers ended without a word. Returns how many run."""
        running = 0
        for trial in trials:
            if trial.state != self._optuna.trial.TrialState.RUNNING:
                continue
            # One without a name lost its worker before that was written, or else this process would not be alone.
            if self._workers.lives(trial.user_attrs.get("worker", "nobody")):
                running += 1
            else:
                say(f"trial {trial.number} lost its worker and is tried again")
                self._abandon(trial, 1)
        return running

    def count(self, say):
        """How many trials are finished, and how many run; those that lost their workers are neither."""
        with self._workers.alone():
            running = self._abandon_lost(self.study.get_trials(deepcopy=False), say)
            done, failed = self.finished()
        return len(done) + len(failed), running

    def _next(self, trials, say):
        """A trial for this worker, or None with whether to look again: others' trials may come to nothing."""
        with self._workers.alone():
            running = self._abandon_lost(self.study.get_trials(deepcopy=False), say)
            done, failed = self.finished()
            if len(done) + len(failed) + running >= trials:
                return None, running > 0 and len(done) + len(failed) < trials
            trial = self.study.ask()
            trial.set_user_attr("worker", self._workers.name)
            return trial, True

    def _suggest(self, trial, seed):
        # By number, so that a study that was stopped goes on as it would have, and processes that share one differ.
        self.study.sampler = self._optuna.samplers.TPESampler(seed=(seed + trial.number) % 2**32, n_startup_trials=16,
                                                              constant_liar=True)
        policy = {}
        for name in self._searched:
            choices = fields.CHOICES[name]
            step = choices[1] - choices[0]
            if name in fields.CUES:
                policy[name] = trial.suggest_float(name, choices[0], choices[-1], step=step)
            else:
                policy[name] = trial.suggest_categorical(name, choices)
        return policy

    def work(self, runs, base, trials, seed, say):
        """Goes on until `trials` are done, failed ones and those of other workers included."""
        base_seen = runs.ask(base)
        self.begin(base)
        while True:
            trial, more = self._next(trials, say)
            if trial is not None:
                self._run(trial, runs, base, base_seen, trials, seed, say)
            elif more:
                time.sleep(WAIT_S)
            else:
                return

    def _run(self, trial, runs, base, base_seen, trials, seed, say):
        began = time.monotonic()
        try:
            policy = {**base, **self._suggest(trial, seed)}
            trial.set_user_attr("policy", policy)
            asked = time.monotonic()
            value = figures.log_ratio(runs.ask(policy), base_seen)
            if value is None:
                raise served.PolicyRefused("no state could be compared")
            # What the search itself takes is the rest of the time of the trial.
            trial.set_user_attr("stepped_s", time.monotonic() - asked)
        except (served.PolicyRefused, served.RunFailed) as failure:
            trial.set_user_attr("error", str(failure))
            self.study.tell(trial, state=self._optuna.trial.TrialState.FAIL)
            say(f"trial {trial.number} failed: {failure}")
            return
        except BaseException:
            with self._workers.alone():
                self._abandon(self.study.get_trials(deepcopy=False)[trial.number], 0)
            raise
        self.study.tell(trial, value)
        best = self.study.best_trial
        done, failed = self.finished()
        say(f"{len(done) + len(failed)} of {trials} trials: log ratio of E_seen {value:+.4f}, best {best.value:+.4f} "
            f"(trial {best.number}), {time.monotonic() - began:.1f} s")
