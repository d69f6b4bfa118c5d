#!/usr/bin/env python3
"""Parts of a sweep side by side in a folder that behaves as on NFS: no locks, and new journals seen late by others.

  network_files_test.py CDB RESULT_STATES LIBRARY
"""
import os
import pathlib
import sys

from sweep import PATIENCE, Cdb, check, journal, runs, scenario, work_folder

RUNS = 16


def make_new(folder):
    """As if the journals had just been written."""
    for path in journal.journals(folder):
        path.rename(path.with_suffix(".moved"))
        path.with_suffix(".moved").rename(path)


def main():
    cdb = Cdb(*sys.argv[1:3])
    library = sys.argv[3]
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


if __name__ == "__main__":
    main()
