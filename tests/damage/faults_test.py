#!/usr/bin/env python3
"""A command that is killed at a system call, or whose system call fails: nothing finished is lost, the same command goes on,
and its result is the one of an undisturbed run. Needs strace and h5py.

  faults_test.py CDB [COUNT] [--seed N] [--only N] [--list]

Each of COUNT cases runs one of the commands below and disturbs the process of cdb itself (not its workers) at one of its
system calls, drawn among all of them: every second time by SIGKILL, else by an error that this call may return. Then the
same command runs undisturbed. Counted are

  kept       the disturbed command ended as it should: killed, or with a message, or well in spite of the error
  died       by another signal, or hung, or ended with an error and no message
  lost       a run that had ended was executed again
  different  the result is not that of an undisturbed run
  left over  a temporary file, or a folder of runs that are merged

Fails if anything but `kept` was counted.
"""
import argparse
import collections
import pathlib
import random
import shutil
import sqlite3
import subprocess
import sys
import tempfile

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "support"))
import journal  # noqa: E402

try:
    import h5py
except ImportError:
    print("skipped: needs h5py (./setup --readers)")
    sys.exit(77)

TIMEOUT = 60
SCENARIO = """benchmark s {
  cycles 3
  world.side 200
  objects { quantity sweep(2, 3, 4); size 20; linear_velocity uniform(-20, 20) }
  detector sweep(dbvt, sap)
}
"""
# The second of the three runs always fails.
FAILS = "benchmark f { cycles 3; world.side 500; acceleration (0, sweep(0, -1e39, -1) as g, 0) }\n"
# No interval is that narrow, so that all repeats are run, in several rounds.
UNTIL = "benchmark u { cycles 3; world.side 200; repeats 7; objects { quantity sweep(2, 3); size 20 } }\n"
TRACED = "benchmark t { cycles 3; world.side 200; objects { quantity 3; size 20 } }\n"
# The files present before, the command, its result, and the folder of runs that it leaves after success.
COMMANDS = {
    "run": ("new", ["run", "s.cdb", "-q", "-o", "out.h5"], None),
    "go on": ("half", ["run", "s.cdb", "-q", "-o", "out.h5"], None),
    "fresh": ("done", ["run", "s.cdb", "-q", "-o", "out.h5", "--fresh"], None),
    "retry": ("failed", ["run", "f.cdb", "-q", "-o", "out.h5", "--retry", "failed"], None),
    "until": ("new", ["run", "u.cdb", "-q", "-o", "out.h5", "--until", "0.001%"], None),
    "merge": ("all", ["merge", "-o", "out.h5", "out.runs"], "out.runs"),
    "merge --remove": ("all", ["merge", "-o", "out.h5", "out.runs", "--remove"], None),
    "trace": ("new", ["trace", "t.cdb", "-q", "-o", "out.h5"], None),
}
# Errors that a call may return on a healthy kernel with a bad or full disk, or with too little of some resource. Not
# for close: HDF5 crashes in its exit handler after it, when everything is done.
ERRORS = {
    "openat": ["EACCES", "EMFILE", "ENOSPC", "EIO"], "open": ["EACCES", "EMFILE"], "write": ["ENOSPC", "EIO", "EINTR"],
    "pwrite64": ["ENOSPC", "EIO", "EINTR"], "writev": ["ENOSPC", "EIO"], "read": ["EIO", "EINTR"], "pread64": ["EIO", "EINTR"],
    "fsync": ["EIO", "ENOSPC"], "fdatasync": ["EIO", "ENOSPC"], "ftruncate": ["EIO", "ENOSPC"], "fallocate": ["ENOSPC", "EOPNOTSUPP"],
    "rename": ["EIO", "ENOSPC", "EACCES"], "renameat2": ["EINVAL", "ENOSPC"], "link": ["EPERM", "ENOSPC"],
    "linkat": ["EPERM", "ENOSPC"], "unlink": ["EACCES", "EIO"], "mkdir": ["EACCES", "ENOSPC"], "rmdir": ["EACCES", "ENOTEMPTY"],
    "flock": ["ENOLCK", "EINTR"], "fcntl": ["ENOLCK"], "mmap": ["ENOMEM"],
    "clone": ["EAGAIN", "ENOMEM"], "clone3": ["EAGAIN", "ENOMEM"], "vfork": ["EAGAIN"], "poll": ["EINTR"], "ppoll": ["EINTR"],
    "wait4": ["EINTR"], "socketpair": ["EMFILE"], "pipe2": ["EMFILE"], "memfd_create": ["EMFILE", "ENOMEM"],
    "sendmsg": ["EINTR", "EPIPE"], "recvmsg": ["EINTR"], "getdents64": ["EIO"], "newfstatat": ["EACCES"], "statfs": ["EIO"],
    "fstat": ["EIO"], "getrandom": ["EINTR"], "sched_setaffinity": ["EPERM", "EINVAL"],
}


def call(words, folder):
    """Exit status, or None if it hung, and what it said."""
    try:
        end = subprocess.run(words, cwd=folder, capture_output=True, timeout=TIMEOUT, check=False, stdin=subprocess.DEVNULL)
    except subprocess.TimeoutExpired:
        return None, ""
    return end.returncode, (end.stdout + end.stderr).decode(errors="replace")


def runs_of(path):
    """Of a results file: when each finished run began, by its id."""
    with h5py.File(path) as file:
        if "run" not in file or "run_id" not in file["run"]:
            return {}
        ids, starts = file["run/run_id"][...].ravel(), file["run/started"][...].ravel()
        return {id.decode(): start for id, start, status in zip(ids, starts, file["status"][...].ravel()) if status >= 0 and start > 0}


def finished_in(folder):
    """All that has ended, in the result and in journals. Journals are newer. Reads a copy, because reading would put the
    files of a killed process in order."""
    finished = runs_of(folder / "out.h5") if (folder / "out.h5").exists() else {}
    if (folder / "out.runs").exists():
        copy = pathlib.Path(shutil.copytree(folder / "out.runs", folder / "copy.runs"))
        finished.update({run: facts["run/started"] for run, facts in journal.numbers(copy).items() if "run/started" in facts})
        shutil.rmtree(copy)
    return finished


def outcome(path):
    """All of a result that is alike each time."""
    with h5py.File(path) as file:
        names = []
        file.visititems(lambda name, thing: names.append(name) if isinstance(thing, h5py.Dataset) else None)
        wanted = [name for name in sorted(names) if "hash" in name or name.split("/")[-1] in ("status", "run_id", "pairs", "box_min")]
        return [(name, file[name][...].tolist()) for name in wanted]


class Cases:
    def __init__(self, cdb, place):
        self.cdb, self.place = cdb, place
        for name, text in (("s", SCENARIO), ("f", FAILS), ("u", UNTIL), ("t", TRACED)):
            (place / f"{name}.cdb").write_text(text, encoding="utf-8")
        self.before, self.points, self.expected = {}, {}, {}
        for start, commands in {
                "new": [], "done": [["run", "s.cdb"]], "failed": [["run", "f.cdb"]], "half": [["run", "s.cdb", "--shard", "1/2"]],
                "all": [["run", "s.cdb", "--shard", part] for part in ("1/2", "2/2")]}.items():
            self.before[start] = place / f"before-{start}"
            self.before[start].mkdir()
            for file in ("s.cdb", "f.cdb", "u.cdb", "t.cdb"):
                shutil.copy(place / file, self.before[start])
            for words in commands:
                status, said = call([cdb, *words, "-q", "-o", "out.h5"], self.before[start])
                assert status in (0, 3), said
        for name, (_, words, _) in COMMANDS.items():
            folder = self.fresh(name)
            log = folder / "log"
            status, said = call(["strace", "-o", log, cdb, *words], folder)
            assert status in (0, 3), said
            self.expected[name] = (status, outcome(folder / "out.h5"))
            counts = collections.Counter(line.split("(")[0] for line in log.read_text(errors="replace").splitlines() if "(" in line)
            self.points[name] = [(what, n) for what, count in sorted(counts.items()) if what.isidentifier()
                                 for n in range(1, count + 1)]
            shutil.rmtree(folder)

    def fresh(self, name):
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.place))
        shutil.copytree(self.before[COMMANDS[name][0]], folder, dirs_exist_ok=True)
        return folder

    def draw(self, number, seed):
        """The command, the call, which one of them, and what happens to it."""
        chance = random.Random(f"{seed} {number}")
        name = list(COMMANDS)[number // 2 % len(COMMANDS)]
        if number % 2 == 0:
            what, n = chance.choice([point for point in self.points[name] if point[0] not in ("exit_group", "execve")])
            return name, what, n, "signal=SIGKILL"
        kinds = sorted({what for what, _ in self.points[name] if what in ERRORS})
        what = chance.choice(kinds)  # each kind equally often, because most calls are reads
        n = chance.choice([n for there, n in self.points[name] if there == what])
        return name, what, n, "error=" + chance.choice(ERRORS[what])

    def attempt(self, number, seed):
        """What was wrong, as (kind, text), and a line that says what was done."""
        name, what, n, how = self.draw(number, seed)
        _, words, leaves = COMMANDS[name]
        did = f"{number}: {name}: {what} {n} {how}"
        folder, faults = self.fresh(name), []
        known = {} if name == "fresh" else finished_in(folder)
        status, said = call(["strace", "-o", "/dev/null", "-e", f"trace={what}", "-e", f"inject={what}:{how}:when={n}", self.cdb, *words], folder)
        is_kill = how.startswith("signal")
        if status is None or (status < 0 and not (is_kill and status == -9)) or status >= 128 and not is_kill:
            faults.append(("died", f"exit status {status}: {said}"))
        elif status not in (0, 3) and not is_kill and not said.strip():
            faults.append(("died", f"exit status {status} without a message"))
        did += f"; exit status {status}"
        try:
            if name != "trace":
                known = {**known, **finished_in(folder)}
        except (OSError, sqlite3.Error, ValueError) as error:
            faults.append(("lost", f"a file is damaged: {error}"))
        out = folder / "out.h5"
        has_ended = name == "merge --remove" and out.exists() and not (folder / "out.runs").exists()  # nothing is left to merge
        again, said = (self.expected[name][0], "") if has_ended else call([self.cdb, *words], folder)
        if (again, outcome(out) if out.exists() else None) != self.expected[name]:
            faults.append(("different", f"exit status {again}: {said}"))
        elif name not in ("trace", "retry", "fresh"):
            now = runs_of(out)
            lost = [run for run, start in known.items() if now.get(run) != start]
            if lost:
                faults.append(("lost", f"{len(lost)} of {len(known)} finished runs"))
        there = {path.name for path in folder.iterdir()} - {"out.h5", "s.cdb", "f.cdb", "u.cdb", "t.cdb", leaves}
        if there:
            faults.append(("left over", " ".join(sorted(there))))
        shutil.rmtree(folder)
        return faults, did


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("cdb", type=lambda path: str(pathlib.Path(path).resolve()))
    parser.add_argument("count", type=int, nargs="?", default=28)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int)
    parser.add_argument("--list", action="store_true")
    arguments = parser.parse_args()
    if subprocess.run(["strace", "-o", "/dev/null", "true"], capture_output=True, check=False).returncode != 0:
        print("skipped: strace must not trace here")
        return 77
    counts, said = collections.defaultdict(collections.Counter), []
    with tempfile.TemporaryDirectory() as place:
        cases = Cases(arguments.cdb, pathlib.Path(place))
        numbers = range(arguments.count) if arguments.only is None else [arguments.only]
        for number in numbers:
            faults, did = cases.attempt(number, arguments.seed)
            if arguments.list:
                print(did)
            name = cases.draw(number, arguments.seed)[0]
            counts[name]["killed" if number % 2 == 0 else "failing"] += 1
            counts[name].update([kind for kind, _ in faults] or ["kept"])
            said += [f"{did}: {kind}: {text}" for kind, text in faults]
    columns = ["killed", "failing", "kept", "died", "lost", "different", "left over"]
    print(f"{'':16}" + "".join(f"{column:>11}" for column in columns))
    for name, row in counts.items():
        print(f"{name:16}" + "".join(f"{row[column]:11}" for column in columns))
    print("\n".join(said))
    return bool(said)


if __name__ == "__main__":
    sys.exit(main())
