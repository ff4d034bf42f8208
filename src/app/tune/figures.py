# SPDX-License-Identifier: MIT
"""How policies are compared over several runs: ratios of E_seen, and how sure they are."""
import math
import random

# Draws of the bootstrap, as in `poise compare`.
DRAWS = 2000
# E_seen below this is nothing: keeps the ratio of two zeros defined. Far below what the reference resolves.
LEAST_MPS = 1e-6
# Fewer states conclude nothing, as in `poise compare`: where all ratios lie on one side of 1, their interval never
# holds 1, even of two states. The least number of which a sign test with two sides can be significant at 5 %.
LEAST_STATES = 6


def _pairs(trial, base, budget):
    """(E_seen of the trial, of the base) of each state that counts: both are defined at every budget."""
    return [(t[budget], b[budget]) for t, b in zip(trial, base) if None not in t and None not in b]


def _log_ratio(pairs):
    trial, base = sum(t for t, _ in pairs), sum(b for _, b in pairs)
    least = LEAST_MPS * len(pairs)
    return math.log(max(trial, least) / max(base, least))


def log_ratio(trial, base, budgets=None):
    """Mean over runs and budgets of log(mean E_seen of the trial / mean E_seen of the base). `trial` and `base` are
    lists of runs, each a list of states, each a list of E_seen by budget, in m/s. None: no state counts."""
    logs = []
    for t, b in zip(trial, base):
        for k in budgets if budgets is not None else range(len(b[0])):
            pairs = _pairs(t, b, k)
            if pairs:
                logs.append(_log_ratio(pairs))
    return sum(logs) / len(logs) if logs else None


def ratio(trial, base, seed, budgets=None):
    """exp(log_ratio) with its 95 % interval: bootstrap by percentiles (Efron 1979) in two stages, runs and then the
    states of each, since states of a run are more alike than runs. Below 1: the trial leaves less error. `states` is
    how many count in all runs; one has no interval. None: no state counts."""
    mean = log_ratio(trial, base, budgets)
    if mean is None:
        return None
    drawn = random.Random(seed)
    runs = []
    for t, b in zip(trial, base):
        columns = [_pairs(t, b, k) for k in (budgets if budgets is not None else range(len(b[0])))]
        if columns and columns[0]:
            runs.append(columns)
    count = sum(len(columns[0]) for columns in runs)
    if count < 2:
        return {"ratio": math.exp(mean), "low": None, "high": None, "states": count}
    means = []
    for _ in range(DRAWS):
        logs = 0.0
        for _ in runs:
            columns = runs[drawn.randrange(len(runs))]
            size = len(columns[0])
            states = [drawn.randrange(size) for _ in range(size)]
            logs += sum(_log_ratio([column[i] for i in states]) for column in columns) / len(columns)
        means.append(logs / len(runs))
    means.sort()
    return {"ratio": math.exp(mean), "low": math.exp(means[int(0.025 * (DRAWS - 1))]),
            "high": math.exp(means[math.ceil(0.975 * (DRAWS - 1))]), "states": count}


def too_few(figure):
    """Whether a ratio is of too few states to conclude anything."""
    return figure["states"] < LEAST_STATES


def means_by_budget(policies):
    """E_seen of each policy and budget: mean over runs of the mean over the states that are defined for all of them."""
    means = [[[] for _ in policy[0][0]] for policy in policies]
    for runs in zip(*policies):
        count = [all(None not in run[i] for run in runs) for i in range(len(runs[0]))]
        for mean, run in zip(means, runs):
            states = [state for state, counts in zip(run, count) if counts]
            for k, column in enumerate(mean):
                if states:
                    column.append(sum(state[k] for state in states) / len(states))
    return [[sum(column) / len(column) if column else None for column in mean] for mean in means]


def shown(figure):
    """A ratio as text."""
    if figure is None:
        return "-"
    if figure["low"] is None:
        return f"{figure['ratio']:.3f} (-)"
    return f"{figure['ratio']:.3f} ({figure['low']:.3f} to {figure['high']:.3f})"
