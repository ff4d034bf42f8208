# SPDX-License-Identifier: MIT
"""The file of a study, which workers of one or several machines share, and how they see that one of them has died.

Beside the journal FILE is the folder FILE.workers. A worker holds a lock on a file of its own there for as long as it
lives. The system drops the locks of a process that ends, however it ends, and those of a machine that is lost, so
nothing has to be cleared up by hand. Locks are those of POSIX (fcntl), which a shared file system must keep between its
machines.
"""
import contextlib
import fcntl
import json
import os
import socket
import uuid


# What the lines of a journal begin with.
_LINE = b'{"op_code": '


class _Lock:
    """A lock on a whole file. Not for two threads at once."""

    def __init__(self, path):
        self._path = path
        self._file = None

    def acquire(self):
        self._file = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        fcntl.lockf(self._file, fcntl.LOCK_EX)
        return True

    def release(self):
        file, self._file = self._file, None
        os.close(file)


def backend(optuna, path, folder):
    """The file as Optuna's journal reads and writes it. Optuna's own lock outlives a process that is killed while it
    writes, and its reader stops for ever at a line that such a process left unfinished."""

    class Lines(optuna.storages.JournalFileStorage):
        def __init__(self):
            super().__init__(path)
            self._write_lock = _Lock(os.path.join(folder, "write"))
            self._starts = {0: 0}

        def read_logs(self, log_number_from):
            logs = []
            number = log_number_from if log_number_from in self._starts else 0
            with open(path, "rb") as file:
                file.seek(self._starts[number])
                for line in file:
                    if not line.endswith(b"\n"):
                        if not _LINE.startswith(line[:len(_LINE)]):
                            raise ValueError("is no journal of a study")
                        break  # is being written, or never will be
                    self._starts[number + 1] = self._starts[number] + len(line)
                    if number >= log_number_from:
                        logs.append(json.loads(line))
                    number += 1
            return logs

        def append_logs(self, logs):
            self._write_lock.acquire()
            try:
                with open(path, "r+b") as file:
                    end = self._end_of_lines(file)
                    file.truncate(end)
                    file.seek(end)
                    file.write(b"".join(json.dumps(log).encode() + b"\n" for log in logs))
                    file.flush()
                    # What a trial came to lasts; parameters without it are worth nothing after a loss of power, and a
                    # trial has many. Other machines see a file that was closed.
                    if any("state" in log for log in logs):
                        os.fsync(file.fileno())
            finally:
                self._write_lock.release()

        @staticmethod
        def _end_of_lines(file):
            """Where the last whole line ends: what follows is of a writer that died, since this one has the lock."""
            end = file.seek(0, os.SEEK_END)
            block = 4096
            while end > 0:
                start = max(0, end - block)
                file.seek(start)
                found = file.read(end - start).rfind(b"\n")
                if found >= 0:
                    return start + found + 1
                end = start
            return 0

    return Lines()


class Workers:
    """Who works on a journal: this process, under `name`, and others."""

    def __init__(self, journal):
        self.folder = journal + ".workers"
        os.makedirs(self.folder, exist_ok=True)
        self.name = f"{socket.gethostname()}-{os.getpid()}-{uuid.uuid4().hex[:8]}"
        self._claim = _Lock(os.path.join(self.folder, "claim"))
        self._alive = _Lock(self._file(self.name))
        self._alive.acquire()

    def _file(self, name):
        return os.path.join(self.folder, "alive-" + name)

    @contextlib.contextmanager
    def alone(self):
        """Of all workers one at a time is in here."""
        self._claim.acquire()
        try:
            yield
        finally:
            self._claim.release()

    def lives(self, name):
        """Whether a worker has not ended. The file of one that has is removed."""
        if name == self.name:
            return True
        try:
            file = os.open(self._file(name), os.O_RDWR | os.O_CLOEXEC)
        except FileNotFoundError:
            return False
        try:
            fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except (BlockingIOError, PermissionError):
            return True
        finally:
            os.close(file)
        os.remove(self._file(name))
        return False

    def leave(self):
        with contextlib.suppress(FileNotFoundError):
            os.remove(self._file(self.name))
        self._alive.release()
