"""What the tests of this folder share: a sweep, and the programs cdb and result_states."""
import contextlib
import os
import pathlib
import subprocess
import sys
import tempfile
import time

PATIENCE = 240  # s, for steps that should take a few: a busy machine is not a failure


def scenario(name, points, cycles=400):
    """Two detectors at each point; a run takes a tenth of a second or so."""
    return (f'benchmark {name} "A sweep on many machines" {{\n  cycles {cycles}\n  world.side 600\n  record timing\n'
            f"  objects {{ quantity sweep(101 .. {100 + points}); linear_velocity uniform(-300, 300) }}\n"
            "  detector sweep(sap32, dbvt)\n}\n")


@contextlib.contextmanager
def work_folder():
    with tempfile.TemporaryDirectory(prefix="cdb-cluster-", ignore_cleanup_errors=True) as name:
        folder = pathlib.Path(name)
        folder.chmod(0o755)  # required by munged
        os.chdir(folder)
        yield folder


def wait_until(is_true, what):
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until:
        if (found := is_true()):
            return found
        time.sleep(0.02)
    sys.exit(f"waited {PATIENCE} s for {what}")


def run(*words, status=0, **more):
    end = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False, timeout=PATIENCE, **more)
    check(end.returncode == status, f"{words} ended with {end.returncode}: {end.stdout}{end.stderr}")
    return end


def check(is_true, what):
    if not is_true:
        sys.exit(f"FAILED: {what}")


class Cdb:
    def __init__(self, cdb, result_states):
        self.path, self._result_states = cdb, result_states

    def run(self, *words, **more):
        return run(self.path, *words, **more)

    def start(self, *words, **more):
        return subprocess.Popen([self.path, *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more)

    def states(self, results):
        return run(self._result_states, results).stdout.splitlines()

    def check_same(self, results, local):
        check(self.states(results) == self.states(local), f"{results} has other runs or states than {local}")


def shards(folder):
    return sorted(pathlib.Path(folder).glob("*.h5"))


def skip(why):
    print(f"skipped: {why}")
    sys.exit(77)
