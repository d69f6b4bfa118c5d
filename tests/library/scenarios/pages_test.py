#!/usr/bin/env python3
"""The tables of the pages in library/scenarios are those that their commands print today.

  pages_test.py CDB SCENARIOS

A page shows a command and what it printed:

    ```console
    $ cdb run settings/margin
    $ cdb show settings_margin.h5 --error penetration
      margin  step  penetration
      ...
    ```

The commands are run on copies of the scenarios with a few cycles and objects. What they print must have the same columns
and as many rows; the numbers are those of another size and another machine.
"""
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

BLOCK = re.compile(r"^```console\n(.*?)^```$", re.M | re.S)
REDUCED = [(r"(?m)^(\s*cycles\s+)\d+$", r"\g<1>24"), (r"(?m)^(\s*warmup\s+)\d+$", r"\g<1>2"),
           (r"(?m)^(\s*quantity\s+)\d{3,}$", r"\g<1>60")]


def tables(text):
    """Of each table its columns, and the number of its rows."""
    found = []
    lines = text.splitlines()
    for i, line in enumerate(lines):
        if i > 0 and re.fullmatch(r"\s*-{10,}", line):
            rows = 0
            while i + 1 + rows < len(lines) and re.match(r"\s+\S", lines[i + 1 + rows]) and not lines[
                    i + 1 + rows].strip().startswith(("Median", "Mean", "Over", "The", "*")):
                rows += 1
            found.append((lines[i - 1].split(), rows))
    return found


def main():
    cdb, scenarios = sys.argv[1], pathlib.Path(sys.argv[2])
    blocks = [(page, block) for page in sorted(scenarios.rglob("*.md")) for block in BLOCK.findall(page.read_text())]
    if not blocks:
        sys.exit(f"no page in {scenarios} shows a command")
    faults = 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for source in scenarios.rglob("*.cdb"):
            copy = folder / source.relative_to(scenarios)
            copy.parent.mkdir(parents=True, exist_ok=True)
            text = source.read_text()
            for pattern, by in REDUCED:
                text = re.sub(pattern, by, text)
            copy.write_text(text)
        for source in [*scenarios.rglob("*.obj"), *scenarios.rglob("*.binvox")]:
            shutil.copy(source, folder / source.relative_to(scenarios))
        done = set()
        for page, block in blocks:
            commands = re.findall(r"^\$ (.*)$", block, re.M)
            printed = ""
            for command in commands:
                words = shlex.split(command)
                assert words[0] == "cdb", command
                words = [cdb] + [f"{w}.cdb" if (folder / f"{w}.cdb").exists() else w for w in words[1:]]
                if words[1] == "run":
                    if command in done:
                        continue
                    done.add(command)
                    words.append("-q")
                result = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=300)
                if result.returncode not in (0, 3):
                    sys.exit(f"{page}: {command}: exit status {result.returncode}\n{result.stderr}")
                printed = result.stdout
            there, now = tables(block), tables(printed)
            if not there or any(table not in now for table in there):
                faults += 1
                print(f"{page}: {commands[-1]}\n  the page has    {there}\n  it prints today {now}")
    print(f"{len(blocks)} tables, {faults} of them of another form than today's")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
