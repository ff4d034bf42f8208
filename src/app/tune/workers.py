# SPDX-License-Identifier: MIT
"""Workers of one study: processes of this machine, or tasks of a Slurm job array. Each is this command once more, with
--task NUMBER: it opens the journal, does trials until there are enough, and writes no policy."""
import os
import subprocess
import threading
import time

from options import Refused

# Looks at the journal while workers are at work; Slurm is asked rarely, since all users of the site share it.
LOOK_S = 0.5
ASK_SLURM_S = 3
# So long no array must be active before it is over: squeue leaves out a task for a moment while it is put back into the
# queue, and a shared file system may show a new line late.
SURELY_OVER_S = 5
# After SIGTERM a worker tells the journal of its trial.
END_S = 20

UNFINISHED = 1


def end_with_input():
    """SIGTERM for this process once its input ends: what a caller that was killed closes too."""
    def wait():
        while os.read(0, 4096):
            pass
        os.kill(os.getpid(), 15)
    threading.Thread(target=wait, daemon=True).start()


def _unfinished(finished, trials, why):
    raise Refused(f"{finished} of {trials} trials are finished: {why}; the same command goes on", UNFINISHED)


def _words(options, words):
    return [options.poise, "tune", *words]


def run_local(study, options, words, say):
    """Starts the workers and waits until they have ended."""
    # Sessions of their own, so that Ctrl-C is for this process alone, which then ends them.
    children = [subprocess.Popen([*_words(options, words), "--task", str(task), "--ends-with-input"],
                                 stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, start_new_session=True)
                for task in range(options.workers)]
    codes = {}
    try:
        while len(codes) < len(children):
            time.sleep(LOOK_S)
            for task, child in enumerate(children):
                if task not in codes and child.poll() is not None:
                    codes[task] = child.returncode
                    if child.returncode < 0:
                        say(f"worker {task} was ended by signal {-child.returncode}")
    finally:
        for child in children:
            child.terminate()
        for child in children:
            try:
                child.wait(END_S)
            except subprocess.TimeoutExpired:
                child.kill()
                child.wait()
            # Not before, or it would get a second signal, which ends it at once.
            child.stdin.close()
    finished, _ = study.count(say)
    if finished < options.trials:
        refusals = [code for code in codes.values() if code > 0]
        if refusals:
            raise Refused(f"{finished} of {options.trials} trials are finished: a worker ended with exit code "
                          f"{refusals[0]}", refusals[0])
        _unfinished(finished, options.trials, "their workers were ended")


def _job_array(options, folder, *more):
    said = subprocess.run([options.poise, "job-array", "--folder", folder, *more], stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, check=False, text=True)
    if said.returncode != 0:
        # It has said why.
        raise Refused("the workers cannot be started by Slurm", said.returncode)
    return said.stdout.split()


def run_slurm(study, options, words, folder, say):
    """Submits the workers, unless an earlier call's are in the queue, and waits until there are enough trials."""
    if study.count(say)[0] >= options.trials:
        return
    slurm = ["--exclusive"] if options.exclusive else []
    slurm += ["--partition", options.partition] if options.partition else []
    slurm += [f"--sbatch={option}" for option in options.sbatch]
    slurm += ["--tasks-at-once", str(options.tasks_at_once)] if options.tasks_at_once else []
    active = _job_array(options, folder)
    if active:
        say(f"waiting for the workers of job array {', '.join(active)}")
    else:
        name = "poise-tune-" + os.path.basename(options.out).removesuffix(".json")
        _job_array(options, folder, "--submit", name, "--tasks", str(options.workers), "--cores", str(options.jobs),
                   "--task-limit-s", str(options.task_limit_s), *slurm, "--", *_words(options, words))
    finished = _wait(study, options, folder, say)
    if finished < options.trials:
        _unfinished(finished, options.trials, f"no worker is in the queue; their logs are in {folder}")


def _wait(study, options, folder, say):
    over = asked = None
    told = -1
    while True:
        finished, _ = study.count(say)
        if finished != told:
            say(f"{finished} of {options.trials} trials")
            told = finished
        if finished >= options.trials:
            return finished
        now = time.monotonic()
        if asked is None or now - asked > ASK_SLURM_S:
            asked = now
            if _job_array(options, folder):
                over = None
            elif over is None:
                over = now
            elif now - over > SURELY_OVER_S:
                return study.count(say)[0]
        time.sleep(LOOK_S)
