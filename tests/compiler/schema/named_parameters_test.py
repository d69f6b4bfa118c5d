#!/usr/bin/env python3
"""Checks that a misspelt parameter or series, or one of another type, is a compile error.

Usage: named_parameters_test.py SOURCE COMPILER [ARGUMENT...]
Compiles SOURCE as it is, which must succeed, and with the macro FAULTS, which must fail at each line that ends in
`// refused: REASON`, for that reason, and at no other line.
"""
import os
import pathlib
import re
import subprocess
import sys

REFUSED = re.compile(r"// refused: (.+)$")


def messages_of(command):
    """The exit status and the messages of a compiler."""
    english = dict(os.environ, LC_ALL="C")
    result = subprocess.run(command, capture_output=True, text=True, check=False, env=english)
    return result.returncode, result.stderr


def messages_by_line(messages, source):
    """The messages that follow each mention of a line of SOURCE, by its number; 0 for those before the first mention."""
    mention = re.compile(re.escape(source) + r":(\d+):")
    number, by_line = 0, {}
    for message in messages.splitlines():
        found = mention.search(message)
        number = int(found[1]) if found else number
        by_line[number] = by_line.get(number, "") + message + "\n"
    return by_line


def main():
    source, *command = sys.argv[1:]
    command += ["-fsyntax-only", source]
    status, messages = messages_of(command)
    if status != 0:
        sys.exit(f"{source} does not compile:\n{messages}")

    status, messages = messages_of(command + ["-DFAULTS"])
    by_line = messages_by_line(messages, source)
    lines = pathlib.Path(source).read_text(encoding="utf-8").splitlines()
    expected = {number: found[1] for number, line in enumerate(lines, 1) if (found := REFUSED.search(line))}
    failed = status == 0 or not expected
    for number, reason in expected.items():
        if "error: " not in by_line.get(number, ""):
            print(f"{source}:{number}: compiles: {lines[number - 1]}")
            failed = True
        elif reason not in by_line[number]:
            print(f"{source}:{number}: does not compile, but for another reason:\n{by_line[number]}")
            failed = True
    for number, text in by_line.items():
        if "error: " in text and number not in expected:
            print(f"{source}:{number}: should compile:\n{text}")
            failed = True
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
