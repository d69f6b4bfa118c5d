#!/usr/bin/env python3
"""Checks that a misspelt parameter, or one of another type, is a compile error.

Usage: named_parameters_test.py SOURCE COMPILER [ARGUMENT...]
Compiles SOURCE as it is, which must succeed, and once for each of the macros that it tests, which must fail in the
constructor that looks the name up.
"""
import re
import subprocess
import sys

REASONS = ("NoSuchParameter", "ParameterHasAnotherKind", "constant expression")


def compile_source(command, macro=None):
    define = [f"-D{macro}"] if macro else []
    return subprocess.run(command + define, capture_output=True, text=True, check=False)


def main():
    source, *command = sys.argv[1:]
    command += ["-fsyntax-only", source]
    good = compile_source(command)
    if good.returncode != 0:
        sys.exit(f"{source} does not compile:\n{good.stderr}")
    with open(source, encoding="utf-8") as file:
        macros = re.findall(r"^#(?:el)?if defined\((\w+)\)", file.read(), re.M)
    failed = not macros
    for macro in macros:
        result = compile_source(command, macro)
        if result.returncode == 0:
            print(f"{macro} compiles")
            failed = True
        elif not any(reason in result.stderr for reason in REASONS):
            print(f"{macro} does not compile, but for another reason:\n{result.stderr}")
            failed = True
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
