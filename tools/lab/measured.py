"""Runs processes, and measures their time and memory. Comparisons in this folder share it.

This file is also the program that starts the measured process: what the kernel counts as the largest memory of a
process includes that of the program that started it, and this one is small.
"""

import json
import os
import signal
import sys
import time


class Skipped(Exception):
    """A program that has no result, and why."""


class Refused(Skipped):
    """A program that ended with a message and a code that is not 0."""


class Crashed(Skipped):
    """A program that a signal ended."""


class TooSlow(Skipped):
    """A program that took more than the limit."""


class Run:
    """Seconds of a process from start to end, those of processors, its largest resident memory in bytes, and output."""

    def __init__(self, seconds, processors, peak, printed):
        self.seconds, self.processors, self.peak, self.printed = seconds, processors, peak, printed

    def __add__(self, later):
        times = self.seconds + later.seconds, self.processors + later.processors
        return Run(*times, max(self.peak, later.peak), self.printed + later.printed)


def run(command, limit=None, one_processor=False, **variables):
    """Runs a process; the other variables are of its environment."""
    import subprocess

    command = [str(part) for part in command]
    environment = os.environ | {name: str(value) for name, value in variables.items()}
    read, write = os.pipe()
    how = json.dumps({"limit": limit, "one_processor": one_processor, "report": write})
    starter = [sys.executable, "-I", "-S", __file__, how, *command]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "errors": "replace"}
    try:
        with os.fdopen(read) as report:
            done = subprocess.run(starter, env=environment, pass_fds=[write], check=False, **pipes)
            os.close(write)
            measured = json.loads(report.read())
    except json.JSONDecodeError:
        raise Skipped(f"was not started: {done.stderr.strip()}") from None
    if measured["stopped"]:
        raise TooSlow(f"more than {limit:g} s")
    if measured["missing"]:
        raise Skipped(f"{command[0]} is not installed")
    code = measured["code"]
    if code < 0:
        raise Crashed(f"{signal.Signals(-code).name}")
    if code > 0:
        lines = (done.stderr.strip() or done.stdout.strip() or f"exit code {code}").splitlines()
        raise Refused(lines[-1])
    return Run(measured["seconds"], measured["processors"], measured["peak"], done.stdout)


def start(command, one_processor, missing):
    """Becomes the measured process. Its group has the processes that it starts."""
    os.setsid()
    if one_processor:
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    try:
        os.execvp(command[0], command)
    except OSError:
        os.write(missing, b"x")
        os._exit(127)


def main(how, command):
    how = json.loads(how)
    os.set_inheritable(how["report"], False)
    said, missing = os.pipe()
    began = time.perf_counter()
    child = os.fork()
    if child == 0:
        start(command, how["one_processor"], missing)
    os.close(missing)
    stopped = []

    def stop(*_):
        stopped.append(True)
        os.killpg(child, signal.SIGKILL)

    signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, how["limit"] or 0)
    _, status, usage = os.wait4(child, 0)
    seconds = time.perf_counter() - began
    signal.setitimer(signal.ITIMER_REAL, 0)
    report = {
        "seconds": seconds,
        "processors": usage.ru_utime + usage.ru_stime,
        "peak": usage.ru_maxrss * 1024,
        "code": os.waitstatus_to_exitcode(status),
        "stopped": bool(stopped),
        "missing": os.read(said, 1) != b"",
    }
    os.write(how["report"], json.dumps(report).encode())


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
