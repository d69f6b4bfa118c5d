#!/usr/bin/env python3
"""Parts of a sweep side by side in a folder that behaves as on NFS: no locks, and new journals seen late by others.

  network_files_test.py CDB RESULT_STATES LIBRARY [KILLS]
"""
import os
import pathlib
import random
import shutil
import signal
import sys
import time

from sweep import PATIENCE, Cdb, check, journal, runs, scenario, work_folder

RUNS = 16


def make_new(folder):
    """As if the journals had just been written."""
    for path in journal.journals(folder):
        path.rename(path.with_suffix(".moved"))
        path.with_suffix(".moved").rename(path)


def kill_and_go_on(cdb, environment, kills):
    """Two drivers side by side; one is killed with its workers at any moment, and goes on: it keeps each run that its journal
    had, and so does the merge."""
    pathlib.Path("killed.cdb").write_text(scenario("killed", RUNS, cycles=3), encoding="utf-8")
    cdb.run("run", "-q", "killed.cdb", "-o", "killed-local.h5")
    draw = random.Random(1)
    kept = unfinished = 0

    def start(part):
        return cdb.start("run", "-q", "killed.cdb", "--shard", f"{part}/2", env=environment, start_new_session=True)

    def end(part):
        text, _ = part.communicate(timeout=PATIENCE)
        check(part.returncode == 0, text)

    longest = 0.3  # s
    for turn in range(kills):
        other, victim = start(1), start(2)
        time.sleep(draw.uniform(0, longest))
        for group in (other, victim):
            os.killpg(group.pid, signal.SIGSTOP)
        # Of a commit that is under way, SQLite undoes what is in a copy as it does in the journal.
        shutil.copytree("killed.runs", "killed.copy") if os.path.exists("killed.runs") else os.mkdir("killed.copy")
        unfinished += any(path.stat().st_size > 0 for path in pathlib.Path("killed.copy").glob("*-journal"))
        before = runs("killed.copy")
        os.killpg(victim.pid, signal.SIGKILL)
        victim.communicate(timeout=PATIENCE)
        os.killpg(other.pid, signal.SIGCONT)
        end(other)
        end(start(2))
        after = runs("killed.runs")
        check(len(after) == 2 * RUNS, f"turn {turn}: {len(after)} of {2 * RUNS} runs")
        lost = [run for run, written in before.items() if after[run] != written]
        check(not lost, f"turn {turn}: finished runs were run again: {lost}")
        kept += len(before)
        cdb.run("merge", "-o", "killed.h5", "killed.runs", env=environment)
        cdb.check_same("killed.h5", "killed-local.h5")
        for folder in ("killed.runs", "killed.copy"):
            shutil.rmtree(folder)
        os.remove("killed.h5")
    print(f"{kills} kills, {unfinished} of them within a commit; {kept} finished runs, none lost")


def main():
    cdb = Cdb(*sys.argv[1:3])
    library = sys.argv[3]
    kills = int(sys.argv[4]) if len(sys.argv) > 4 else 5
    late = dict(os.environ, LD_PRELOAD=library, CDB_TEST_DELAY_MS="2500")
    with work_folder():
        pathlib.Path("net.cdb").write_text(scenario("net", RUNS // 2, cycles=20), encoding="utf-8")
        cdb.run("run", "-q", "net.cdb", "-o", "local.h5")

        # Runs each part twice at the same time, as after a controller has forgotten that it started one.
        parts = [cdb.start("run", "-q", "net.cdb", "--shard", f"{k}/3", env=late) for k in (1, 2, 3, 1, 2, 3)]
        for part in parts:
            text, _ = part.communicate(timeout=PATIENCE)
            check(part.returncode == 0, text)
        check(len(runs("net.runs")) == RUNS, "every run is in a journal")
        check(len(journal.journals("net.runs")) == 6, "each process has a journal of its own")
        check(not list(pathlib.Path("net.runs").glob("*.broken")), "no journal is broken")

        # The journals are not visible yet.
        make_new("net.runs")
        hasty = cdb.run("merge", "-o", "hasty.h5", "net.runs", env=late)
        check(f"of {RUNS} runs" in hasty.stderr, hasty.stderr)
        check(sum(" missing " in line for line in cdb.states("hasty.h5")) >= 3, "a merge that does not wait lacks them")
        make_new("net.runs")
        patient = cdb.run("merge", "--wait", "100", "--remove", "-o", "net.h5", "net.runs", env=late)
        check(f"{RUNS} of {RUNS} runs" in patient.stderr, patient.stderr)
        check("file system without locks" in patient.stderr, patient.stderr)
        check(len(runs("net.runs")) == RUNS, "where nobody can tell who is at work, journals stay")
        cdb.check_same("net.h5", "local.h5")

        # A whole run, with its merge, and the results read there.
        cdb.run("run", "-q", "net.cdb", "-o", "whole.h5", env=late)
        cdb.run("show", "whole.h5", env=late)
        cdb.check_same("whole.h5", "local.h5")

        kill_and_go_on(cdb, dict(late, CDB_TEST_DELAY_MS="0"), kills)


if __name__ == "__main__":
    main()
