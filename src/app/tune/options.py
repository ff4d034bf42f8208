# SPDX-License-Identifier: MIT
"""The command line of `poise tune`."""
import argparse
import json
import os

import fields

BAD_USAGE = 2
BAD_INPUT = 3

_EPILOG = """examples:
  poise tune jacks street --holdout pile maze --bodies 250 --polygons --trials 60 --out mine.json
  poise run pile --policy mine.json
  poise tune jacks street --bodies 250 --trials 200 --engine slurm --workers 8 --out mine.json
  poise tune jacks street --bodies 250 --cues --out cues.json
  poise tune pile maze --bodies 250 --measure --out rivals.json

exit codes: 0 done, 1 workers ended before the last trial, 2 bad usage or Optuna is missing, 3 bad input or no trial succeeded, 4 output failed, 130 stopped by
Ctrl-C, 143 by SIGTERM; the journal of a search keeps what was done, and the same command goes on."""


class Refused(Exception):
    """The command cannot be done; `code` is the exit code."""

    def __init__(self, message, code=BAD_USAGE):
        super().__init__(message)
        self.code = code


class _Parser(argparse.ArgumentParser):
    def error(self, message):
        raise Refused(message)


def _whole(least, most):
    def read(text):
        if not text.isascii() or not text.isdigit() or not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(f"{text!r}, must be a whole number from {least} to {most}")
        return int(text)
    return read


def _seeds(text):
    seeds = [_whole(0, 2**64 - 1)(part) for part in text.split(",")]
    if len(set(seeds)) < len(seeds):
        raise argparse.ArgumentTypeError(f"{text!r}, must not name a seed twice")
    return seeds


def _searched(text):
    names = text.split(",")
    for name in names:
        if name not in fields.CHOICES:
            raise argparse.ArgumentTypeError(f"{name!r}, must be of {', '.join(fields.CHOICES)}")
    if len(set(names)) < len(names):
        raise argparse.ArgumentTypeError(f"{text!r}, must not name a field twice")
    return names


def _path(text):
    if not text:
        raise argparse.ArgumentTypeError("must not be empty")
    return text


def parser():
    p = _Parser(prog="poise tune", allow_abbrev=False, epilog=_EPILOG,
                formatter_class=argparse.RawDescriptionHelpFormatter,
                description="Search the weights of a policy by what it leaves to be seen (E_seen, docs/priorities.md), "
                            "on some scenes and seeds, and measure it on others.")
    p.add_argument("--poise", help=argparse.SUPPRESS, required=True)
    p.add_argument("scenes", metavar="SCENE", nargs="+", help="a scene file, or a scene that ships")
    p.add_argument("--out", metavar="FILE", type=_path, required=True,
                   help="write the policy (poise.policy/1) with its evidence; with --cues or --measure the figures")
    what = p.add_mutually_exclusive_group()
    what.add_argument("--cues", action="store_true", help="search nothing: measure what each cue is worth")
    what.add_argument("--measure", action="store_true", help="search nothing: measure the base policy against its rivals")
    p.add_argument("--holdout", metavar="SCENE", nargs="+", default=[], help="scenes to measure the result on")
    p.add_argument("--seeds", metavar="N,N", type=_seeds,
                   help="seeds of the scenes (default 1,2; of scenes without generators 1)")
    p.add_argument("--holdout-seeds", metavar="N,N", type=_seeds,
                   help="seeds to measure the result on, of all scenes that have generators (default 11,12; of "
                        "held-out scenes without generators 11)")
    p.add_argument("--trials", metavar="N", type=_whole(1, 100000), default=40,
                   help="trials of the study, those in the journal included (default 40)")
    p.add_argument("--jobs", metavar="N", type=_whole(1, 256),
                   help="scenes that a worker steps at a time (default: processors for each worker; with slurm 1)")
    p.add_argument("--journal", metavar="FILE", type=_path,
                   help="the study: it is gone on with, and several processes may share it (default OUT.journal)")
    _add_workers(p)
    p.add_argument("--base", metavar="FILE", type=_path, help="policy file with what is not searched")
    p.add_argument("--search", metavar="FIELD,FIELD", type=_searched, default=list(fields.SEARCHED),
                   help=f"fields of the policy (default {','.join(fields.SEARCHED)}; also "
                        f"{','.join(f for f in fields.CHOICES if f not in fields.SEARCHED)})")
    p.add_argument("--rivals", metavar="P,P", type=lambda text: [name for name in text.split(",") if name],
                   help="policies to measure against (default size,random,fifo,round-robin and, without --history, "
                        "oracle)")
    p.add_argument("--budgets", metavar="B,B", default="12.5%,25%,50%",
                   help="as in poise compare (default 12.5%%,25%%,50%%)")
    p.add_argument("--from", metavar="B", dest="budget_from", default="25%",
                   help="budget of the run that makes the states (default 25%%)")
    p.add_argument("--frames", metavar="N", type=_whole(1, 100000), default=8, help="states of a run (default 8)")
    p.add_argument("--every", metavar="N", type=_whole(1, 100000), default=10,
                   help="frames from state to state (default 10)")
    p.add_argument("--warmup", metavar="N", type=_whole(0, 100000), default=40,
                   help="frames before the first state (default 40)")
    p.add_argument("--history", metavar="N", type=_whole(1, 10000), default=1,
                   help="frames that each policy steps by itself from a state (default 1)")
    p.add_argument("--bodies", metavar="N", type=_whole(1, 10**7), help="bodies of the generators of each scene")
    p.add_argument("--polygons", action="store_true", help="the last level of meshes is their polygons")
    p.add_argument("--seed", metavar="N", type=_whole(0, 2**32 - 1), default=1,
                   help="of the search and of the intervals (default 1)")
    p.add_argument("--name", metavar="TEXT", type=_path, help="name of the policy (default: that of the file)")
    p.add_argument("--quiet", action="store_true", help="no progress and no table")
    return p


def _add_workers(p):
    p.add_argument("--workers", metavar="N", type=_whole(1, 10000),
                   help="processes that do trials of the study at the same time (default 1)")
    p.add_argument("--engine", choices=["local", "slurm"], default="local",
                   help="where they are: local, this machine; slurm, tasks of a job array by sbatch (default local)")
    p.add_argument("--task-limit-s", metavar="S", type=_whole(60, 10**8),
                   help="slurm: a worker is ended after so long, and its trial is another's (default 3600)")
    p.add_argument("--exclusive", action="store_true", help="slurm: each worker has its node to itself")
    p.add_argument("--partition", metavar="P", type=_path, help="slurm: the partition (default: the site's)")
    p.add_argument("--sbatch", metavar="OPTION", action="append", default=[],
                   help="slurm: a further option of sbatch, as --sbatch=--account=me; may be given several times")
    p.add_argument("--tasks-at-once", metavar="N", type=_whole(1, 10**6),
                   help="slurm: workers that run at the same time, at most (default: as many as the site starts)")
    # Of a worker that this command started.
    p.add_argument("--task", type=_whole(0, 10**6), help=argparse.SUPPRESS)
    p.add_argument("--ends-with-input", action="store_true", help=argparse.SUPPRESS)


def _check_workers(options):
    if options.engine == "local":
        given = {"--task-limit-s": options.task_limit_s, "--exclusive": options.exclusive,
                 "--partition": options.partition, "--sbatch": options.sbatch, "--tasks-at-once": options.tasks_at_once}
        for name, value in given.items():
            if value:
                raise Refused(f"{name} needs --engine slurm")
    if (options.cues or options.measure) and (options.workers or options.engine == "slurm"):
        raise Refused("--workers and --engine are of a search: --cues and --measure have none; see --jobs")
    options.workers = options.workers or 1
    options.task_limit_s = options.task_limit_s or 3600
    if options.jobs is None:
        options.jobs = 1 if options.engine == "slurm" else max(1, (os.cpu_count() or 1) // options.workers)


def read_base(file):
    """What the policy file says of the policy. poise reads it again and refuses what it may not say."""
    if file is None:
        return dict(fields.SHIPPED_POLICY)
    try:
        with open(file, encoding="utf-8") as opened:
            policy = json.load(opened)["policy"]
        json.dumps(policy, allow_nan=False)
    except OSError as failure:
        raise Refused(f"{file}: {failure.strerror}", BAD_INPUT) from failure
    except (ValueError, KeyError, TypeError, RecursionError) as failure:
        raise Refused(f"{file}: must be a policy file (poise.policy/1) in JSON without comments", BAD_INPUT) from failure
    if not isinstance(policy, dict):
        raise Refused(f"{file}: policy, must be an object", BAD_INPUT)
    return {**fields.SHIPPED_POLICY, **policy}


def is_special(path):
    """Something that is there and no regular file, nor a folder: a pipe or a device."""
    return os.path.exists(path) and not os.path.isfile(path) and not os.path.isdir(path)


def _check_outputs(options, journal):
    """Refuses outputs into what is read, and into each other."""
    read = [("SCENE", scene) for scene in options.scenes] + [("--holdout", scene) for scene in options.holdout]
    read += [("--base", options.base)] if options.base else []
    read += [("--rivals", rival) for rival in options.rivals]
    for name, path in (("--out", options.out), ("--journal", journal)):
        if os.path.isdir(path):
            raise Refused(f"{name} {path}: is a folder")
        for what, file in read:
            if os.path.isfile(path) and os.path.isfile(file) and os.path.samefile(path, file):
                raise Refused(f"{name} {path}: would overwrite the file that is read as {what}")
    if os.path.realpath(journal) == os.path.realpath(options.out):
        raise Refused("--journal and --out are the same file")
    if options.cues or options.measure:
        return
    if is_special(options.out) and not options.journal:
        raise Refused(f"--out {options.out}: is no file, so --journal must say where the study goes")
    if is_special(journal):
        raise Refused(f"--journal {journal}: must be a file, which workers read again")


def _check_name(options):
    name = options.name or os.path.basename(options.out)
    try:
        name.encode("utf-8")
    except UnicodeEncodeError as failure:
        raise Refused("--name: must be UTF-8" if options.name else
                      "--name is needed where that of the file of --out is not UTF-8") from failure


def check(options):
    """Refuses options that contradict each other."""
    _check_workers(options)
    _check_name(options)
    for group, name in ((options.scenes, "SCENE"), (options.holdout, "--holdout")):
        for scene in group:
            if scene == "-":
                raise Refused(f"{name}: the standard input is read once and cannot be a scene here")
            if group.count(scene) > 1:
                raise Refused(f"{name}: {scene} is given twice")
    for scene in options.holdout:
        if scene in options.scenes:
            raise Refused(f"--holdout: {scene} is searched on; its held-out seeds are measured anyway")
    options.seeds_given, options.holdout_seeds_given = options.seeds is not None, options.holdout_seeds is not None
    options.seeds, options.holdout_seeds = options.seeds or [1, 2], options.holdout_seeds or [11, 12]
    both = sorted(set(options.seeds) & set(options.holdout_seeds))
    if both and not (options.cues or options.measure):
        raise Refused(f"--holdout-seeds: {both[0]} is searched on")
    if options.rivals is None:
        options.rivals = ["size", "random", "fifo", "round-robin"] + (["oracle"] if options.history == 1 else [])
    if options.history > 1 and "oracle" in options.rivals:
        raise Refused("--rivals: oracle knows one frame: it cannot be asked with --history above 1")
    journal = options.journal or options.out + ".journal"
    _check_outputs(options, journal)
    return journal
