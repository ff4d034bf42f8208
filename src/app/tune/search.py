# SPDX-License-Identifier: MIT
"""The search: an Optuna study in a journal that several processes and machines may work on."""
import json
import time
import warnings

import fields
import figures
import served


class WrongJournal(Exception):
    """The journal cannot be read, or holds a study of something else."""


def open_study(optuna, journal, setup):
    """The study of a journal, made if it is not there. Refused: a journal of another setup."""
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    warnings.simplefilter("ignore")
    try:
        storage = optuna.storages.JournalStorage(optuna.storages.JournalFileStorage(journal))
        study = optuna.create_study(study_name="poise", storage=storage, load_if_exists=True, direction="minimize",
                                    sampler=optuna.samplers.RandomSampler())
    except (OSError, ValueError, KeyError) as failure:
        raise WrongJournal(f"--journal {journal}: {failure}") from failure
    known = study.user_attrs.get("setup")
    if known is None:
        study.set_user_attr("setup", setup)
    else:
        for name, value in setup.items():
            if known.get(name) != value:
                raise WrongJournal(f"--journal {journal}: its study has {name} = {json.dumps(known.get(name))}, not "
                                   f"{json.dumps(value)}; name another file, or remove this one")
    return study


def _finished(optuna, study):
    states = optuna.trial.TrialState
    done = [t for t in study.trials if t.state == states.COMPLETE]
    failed = [t for t in study.trials if t.state == states.FAIL and not t.user_attrs.get("stopped")]
    return done, failed


def _begin(study, base, searched):
    """What is known to be sensible is tried first: the base, the weights of the measure, and the base with one cue
    more."""
    shipped = {**fields.SHIPPED, **base}
    more = [{**shipped, cue: 1} for cue in fields.CUES if cue in searched and shipped[cue] == 0]
    for first in (shipped, {**shipped, **fields.LIKE_THE_MEASURE}, *more):
        values = {name: first[name] for name in searched}
        if all(value in fields.CHOICES[name] for name, value in values.items()):
            study.enqueue_trial(values, skip_if_exists=True)


def _suggest(optuna, study, trial, seed, searched):
    # By number, so that a study that was stopped goes on as it would have, and processes that share one differ.
    study.sampler = optuna.samplers.TPESampler(seed=(seed + trial.number) % 2**32, n_startup_trials=16,
                                               constant_liar=True)
    policy = {}
    for name in searched:
        choices = fields.CHOICES[name]
        step = choices[1] - choices[0]
        if name in fields.CUES:
            policy[name] = trial.suggest_float(name, choices[0], choices[-1], step=step)
        else:
            policy[name] = trial.suggest_categorical(name, choices)
    return policy


def search(optuna, study, runs, base, searched, trials, seed, say):
    """Goes on until `trials` are done, failed ones included. Returns (the best trial's policy, how many are done, how
    many failed); no policy where none is done."""
    base_seen = runs.ask(base)
    _begin(study, base, searched)
    while True:
        done, failed = _finished(optuna, study)
        if len(done) + len(failed) >= trials:
            break
        trial = study.ask()
        began = time.monotonic()
        try:
            policy = {**base, **_suggest(optuna, study, trial, seed, searched)}
            trial.set_user_attr("policy", policy)
            value = figures.log_ratio(runs.ask(policy), base_seen)
            if value is None:
                raise served.PolicyRefused("no state could be compared")
        except (served.PolicyRefused, served.RunFailed) as failure:
            trial.set_user_attr("error", str(failure))
            study.tell(trial, state=optuna.trial.TrialState.FAIL)
            say(f"trial {trial.number} failed: {failure}")
            continue
        except BaseException:
            trial.set_user_attr("stopped", True)
            study.tell(trial, state=optuna.trial.TrialState.FAIL)
            raise
        study.tell(trial, value)
        best = study.best_trial
        say(f"{len(done) + len(failed) + 1} of {trials} trials: log ratio of E_seen {value:+.4f}, best {best.value:+.4f} "
            f"(trial {best.number}), {time.monotonic() - began:.1f} s")
    done, failed = _finished(optuna, study)
    best = min(done, key=lambda t: (t.value, t.number)) if done else None
    return (best.user_attrs["policy"] if best else None), len(done), len(failed)
