#!/usr/bin/env python3
"""The ways without Slurm that `cdb doc cluster` shows: xargs, GNU parallel and ssh. GNU parallel is left out where it is not
installed; ssh is a stub here that runs the command in a shell of its own, as the far side does.

  by_hand_test.py CDB RESULT_STATES
"""
import os
import pathlib
import shutil
import subprocess
import sys

from sweep import PATIENCE, Cdb, check, runs, scenario, work_folder


def documented(cdb):
    """The commands, by the program that starts the parts."""
    text = cdb.run("doc", "cluster").stdout
    lines = [line.strip() for line in text.replace("\\\n", " ").splitlines()]
    commands = {"xargs": [], "parallel": [], "ssh": []}
    for line in lines:
        if line.startswith("for k in"):
            commands["ssh"].append(line)
        elif "| xargs" in line and "FILE" in line:
            commands["xargs"].append(line)
        elif "| parallel" in line:
            commands["parallel"].append(line)
    check([len(lines) for lines in commands.values()] == [1, 2, 1], f"the commands are documented: {commands}")
    return commands


def main():
    cdb = Cdb(*sys.argv[1:3])
    commands = documented(cdb)
    with work_folder() as folder:
        binaries = folder / "bin"
        binaries.mkdir()
        (binaries / "cdb").symlink_to(cdb.path)
        # ssh [OPTION…] HOST [--] COMMAND…: joins the words, and the remote shell splits them. It sets SHELL as sshd
        # does; without it GNU parallel runs nothing and succeeds (CI does not set it).
        (binaries / "ssh").write_text('#!/bin/bash\nwhile [[ $1 == -* ]]; do shift; done\nshift\n[[ $1 == -- ]] && shift\n'
                                      'cd /; SHELL=/bin/bash exec bash -c "$*"\n', encoding="utf-8")
        (binaries / "ssh").chmod(0o755)
        environment = dict(os.environ, PATH=f"{binaries}:{os.environ['PATH']}", PARALLEL_SSH=str(binaries / "ssh"),
                           PARALLEL_HOME=str(folder / "home"))
        pathlib.Path("sweep.cdb").write_text(scenario("sweep", 8, cycles=10), encoding="utf-8")
        cdb.run("run", "-q", "sweep.cdb", "-o", "local.h5")
        for program, lines in commands.items():
            if shutil.which(program, path=environment["PATH"]) is None:
                print(f"{program} is not installed")
                continue
            for line in lines:
                end = subprocess.run(["bash", "-c", line.replace("FILE", "sweep.cdb")], env=environment, capture_output=True,
                                     text=True, timeout=PATIENCE, check=False)
                check(end.returncode == 0, f"{line}: {end.stdout}{end.stderr}")
                check(len(runs("out.runs")) == 16, f"{line}: {len(runs('out.runs'))} of 16 runs: {end.stderr}")
                cdb.run("run", "-q", "sweep.cdb", "-o", "out.h5")
                cdb.check_same("out.h5", "local.h5")
                check(not pathlib.Path("out.runs").exists(), "the journals are removed")
                pathlib.Path("out.h5").unlink()


if __name__ == "__main__":
    main()
