#!/usr/bin/env python3
"""`cdb submit` against a real Slurm with two virtual nodes.

  slurm_test.py CDB RESULT_STATES
"""
import pathlib
import re
import signal
import subprocess
import sys
import time

from slurm import Slurm
from sweep import PATIENCE, Cdb, check, journal, runs, scenario, wait_until, work_folder


def finish(process, status):
    text, _ = process.communicate(timeout=PATIENCE)
    check(process.returncode == status, f"cdb submit ended with {process.returncode}: {text}")
    return text


def submitted(folder):
    """Ids of the array and of the merge; both are that of the array until there is a merge."""
    return journal.request(folder, "submission").split()[2:4]


def a_node_dies(cdb, slurm):
    """cdb is killed on one node, the other node dies, and nobody has to do anything. Meanwhile the command that follows is
    stopped, and follows again."""
    out = "a folder's name/big.h5"
    pathlib.Path(out).parent.mkdir()
    folder = out.replace(".h5", ".runs")
    command = ("submit", "big.cdb", "-o", out, "--tasks", "4", "--partition", "bench")
    first = cdb.start(*command)
    wait_until(lambda: len(runs(folder)) > 1 and all(slurm.programs(node, cdb.path) for node in ("n1", "n2")),
               "a task on each node")
    array, _ = submitted(folder)
    first.send_signal(signal.SIGTERM)
    check(f"job {array} continues without this command" in finish(first, 143), "how to follow it again")
    slurm.kill_together(slurm.programs("n1", cdb.path))
    slurm.kill_node("n2")
    second = cdb.start(*command)
    text = finish(second, 0)
    check(f"job {array} is working on" in text, f"the second follows the first job: {text}")
    check(re.search(r"Restarts=[1-9]", slurm.job(array)), f"a task was requeued: {slurm.job(array)}")
    cdb.check_same(out, "big_local.h5")
    check(not pathlib.Path(folder).exists(), "the journals are removed")
    check("is complete" in cdb.run(*command).stderr, "nothing is left to submit")


def a_task_and_the_merge_are_killed(cdb, slurm):
    """The rest is merged, and the same command submits just what is missing. Then the merge is lost, and the command merges."""
    command = ("submit", "small.cdb", "--tasks", "3")
    text = cdb.run(*command, "--no-follow").stderr
    check("3 of 3 tasks of 24 runs" in text, text)
    array, merge = submitted("small.runs")
    wait_until(lambda: runs("small.runs") and slurm.programs("n1", cdb.path), "a task")
    first = next(line for line in slurm.active() if "RUNNING" in line).split()[0].split("_")[1]
    slurm.kill_together([pid for pid in slurm.processes("n1") if not slurm.is_daemon(pid)])
    wait_until(lambda: not slurm.active(), "the end of the jobs")
    states = cdb.states("small.h5")
    missing = sum(" missing " in line for line in states)
    check(0 < missing < 24, f"the merge has what is there: {missing} missing")
    log = pathlib.Path("small.runs", f"slurm-{merge}.log").read_text(encoding="utf-8")
    check(f"{24 - missing} of 24 runs" in log, log)
    check(f"_{first}" in slurm.job(array) or "FAILED" in slurm.job(array), "the task failed")

    again = cdb.start(*command)
    wait_until(lambda: len({*submitted("small.runs"), array, merge}) == 4, "the second jobs")
    array, merge = submitted("small.runs")
    subprocess.run(["scancel", merge], check=True)
    text = finish(again, 0)
    check(f"submitted job {array}: 1 of 3 tasks" in text, text)
    cdb.check_same("small.h5", "small_local.h5")
    check(not pathlib.Path("small.runs").exists(), "the journals are removed")


def refusals(cdb):
    text = cdb.run("submit", "small.cdb", "-o", "refused.h5", "--partition", "nowhere", status=2).stderr
    check("sbatch refuses the job" in text and "partition" in text, text)


def main():
    cdb = Cdb(*sys.argv[1:3])
    with work_folder() as folder, Slurm(folder / "slurm") as slurm:
        for name, points in (("big", 40), ("small", 12)):
            pathlib.Path(f"{name}.cdb").write_text(scenario(name, points), encoding="utf-8")
            cdb.run("run", "-q", f"{name}.cdb", "-o", f"{name}_local.h5")
        refusals(cdb)
        for case in (a_task_and_the_merge_are_killed, a_node_dies):
            begin = time.monotonic()
            case(cdb, slurm)
            print(f"{case.__name__}: {time.monotonic() - begin:.0f} s")


if __name__ == "__main__":
    main()
