#!/usr/bin/env python3
"""Checks the manual, in runtime/manual, and the README.

- Every link to a file or heading of the repository leads there, in all Markdown files.
- The list of pages names each page once, and `cdb doc` prints each, with its generated parts, fitted to a terminal.
- Examples in the language compile.
- Commands are those of the program, with options that they have, and the page of commands has all of them.

  manual_test.py CDB
"""
import os
import pathlib
import pty
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
MANUAL = ROOT / "runtime/manual"
PAGES = [page for page in sorted(MANUAL.glob("*.md")) if page.name != "README.md"]
SOURCES = ("compiler", "dsl", "examples", "library", "runtime", "tests")
README_BYTES = 8192
COLUMNS = 80

FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.M | re.S)
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")

wrong = []


def check(condition, message):
    if not condition:
        wrong.append(message)


def prose(text):
    return FENCE.sub("", text)


def anchors(text):
    """The names of the headings, as a forge makes them."""
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in re.findall(r"^#+ (.*)$", prose(text), re.M)}


def check_links(page):
    text = page.read_text(encoding="utf-8")
    for target in LINK.findall(re.sub(r"`[^`]*`", "", prose(text))):
        if re.match(r"\w+:", target):
            continue
        file, _, anchor = target.partition("#")
        other = page.parent / file if file else page
        if not other.exists():
            wrong.append(f"{page.relative_to(ROOT)}: no such file: {target}")
        elif anchor:
            check(anchor in anchors(other.read_text(encoding="utf-8")), f"{page.relative_to(ROOT)}: no such heading: {target}")


def printed(cdb, *arguments):
    done = subprocess.run([cdb, *arguments], capture_output=True, text=True, check=False)
    check(done.returncode == 0, f"cdb {' '.join(arguments)}: {done.stderr}")
    return done.stdout


def printed_on_terminal(cdb, *arguments):
    terminal, far_end = pty.openpty()
    with subprocess.Popen([cdb, *arguments], stdin=subprocess.DEVNULL, stdout=far_end, env=dict(os.environ, COLUMNS=str(COLUMNS))):
        os.close(far_end)
        read = b""
        while True:
            try:
                part = os.read(terminal, 65536)
            except OSError:  # EIO: nobody writes any more
                part = b""
            if not part:
                break
            read += part
    os.close(terminal)
    return read.decode().replace("\r\n", "\n")


def check_pages(cdb):
    listed = re.findall(r"^- \[`(\w+)`\]\(\1\.md\)", (MANUAL / "README.md").read_text(encoding="utf-8"), re.M)
    check(sorted(listed) == [page.stem for page in PAGES], f"runtime/manual/README.md lists {listed}")
    topics = printed(cdb, "doc")
    for page in PAGES:
        check(re.search(rf"^  {page.stem}  ", topics, re.M), f"cdb doc does not list {page.stem}")
        text = page.read_text(encoding="utf-8")
        code = {line.strip() for _, block in FENCE.findall(text) for line in block.splitlines()}
        shown = printed_on_terminal(cdb, "doc", page.stem)
        check("<!--" not in shown, f"{page.name}: a part that nothing generates: {re.findall('<!--.*?-->', shown)}")
        check("](" not in shown and "```" not in shown, f"{page.name}: Markdown on a terminal")
        for line in shown.splitlines():
            check(len(line) <= COLUMNS or line.strip() in code or " " not in line.strip(), f"cdb doc {page.stem}: not fitted: {line}")


def check_examples(cdb, page):
    for language, text in FENCE.findall(page.read_text(encoding="utf-8")):
        if language != "cdb":
            continue
        if not re.search(r"^(benchmark|use|let) ", text, re.M):
            text = f"benchmark example {{\n{text}}}\n"
        done = subprocess.run([cdb, "check", "-"], input=text, capture_output=True, text=True, check=False)
        errors = set(re.findall(r"error:.*\[(E\d+)", done.stderr))
        # A trace exists once somebody has recorded it.
        check(done.returncode == 0 or errors == {"E0214"}, f"{page.relative_to(ROOT)}:\n{text}{done.stdout}{done.stderr}")


def commands(text):
    """The command lines in code, each as its words."""
    code = [block for language, block in FENCE.findall(text) if language in ("sh", "console")] + re.findall(r"`([^`]+)`", prose(text))
    for block in code:
        for line in re.split(r"[\n;|]|&&", block.replace("\\\n", " ")):
            found = re.search(r"(?:^|[\s'/])cdb +([a-z].*)$", line.strip())
            if found:
                yield found.group(1).split()


def check_commands(cdb):
    helps = {name: printed(cdb, name, "--help") for name in re.findall(r"^  ([a-z]+)  ", printed(cdb, "--help"), re.M)}
    check(len(helps) > 15, f"cdb --help lists {sorted(helps)}")
    described = set()
    for page in PAGES + [ROOT / "README.md"]:
        for name, *words in commands(page.read_text(encoding="utf-8")):
            place = f"{page.relative_to(ROOT)}: cdb {name}"
            if name not in helps:
                wrong.append(f"{place}: no such command")
                continue
            if page.name == "commands.md":
                described.add(name)
            for option in words:
                option = re.match(r"\[?(--?[a-z][\w-]*)", option)
                check(not option or re.search(rf"(?<![\w-]){option.group(1)}(?![\w-])", helps[name]), f"{place} has no {option and option.group(1)}")
    check(described == set(helps), f"runtime/manual/commands.md lacks {set(helps) - described}")


def main():
    cdb = str(pathlib.Path(sys.argv[1]).resolve())
    for page in [*ROOT.glob("*.md"), *(page for top in SOURCES for page in (ROOT / top).rglob("*.md"))]:
        if "node_modules" not in page.parts:
            check_links(page)
    check((ROOT / "README.md").stat().st_size <= README_BYTES, f"README.md is longer than {README_BYTES} bytes")
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        check_pages(cdb)
        for page in PAGES + [ROOT / "README.md"]:
            check_examples(cdb, page)
        check_commands(cdb)
    print("\n".join(wrong) or f"{len(PAGES)} pages are whole")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
