#!/usr/bin/env python3
"""Checks the structure that the sources promise, by reading their includes.

- A top folder includes only itself and the folders below it: dsl, compiler, library, runtime, from the bottom up.
- A room of runtime includes only rooms on the floors below it; `--picture` prints the includes between rooms for Mermaid.
- No two folders include each other, directly or through others.
- Files of the repository that comments and READMEs name exist.
- Only the command line and the reports know the compiler beyond the schema, the plan and its analysis.
- A folder holds at most thirty sources, so that its list fits a screen.
- A file's namespace is cdb:: and the name of its folder.
- Each external library is included where it belongs and nowhere else.
"""
import collections
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.M)
NAMESPACE = re.compile(r"^namespace (cdb[\w:]*) \{", re.M)

MOST_SOURCES = 30  # in a folder
FOLDERS = ("dsl", "compiler", "library", "runtime")  # from the bottom up

# The rooms of runtime, a line a floor, from the bottom up. A room includes rooms of the floors below only.
FLOORS = (
    ("protocol", "omissions", "terminal"),
    ("engine", "manual", "results"),
    ("editor", "figures", "sweep"),
    ("pages", "printers"),
    ("cli",),
)
FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}

# A file that a comment names; NAME stands for any, 20b.cdb for a scenario of the reader's.
CITED = re.compile(r"(?<![\w./$*{-])(?!NAME)((?:[\w-]+/)*(?!NAME)[\w-]+\.(?:h|cc|js|py|md))(?![\w*])")
FOREIGN = {"linux/landlock.h", "cdb/detector.h", "cdb/detector_c.h"}  # of the system; as installed

WHOLE_COMPILER = ("runtime/cli/", "runtime/editor/", "runtime/manual/")
CONTRACT = ("compiler/schema", "compiler/plan", "compiler/analysis", "compiler/yaml")

# A pattern of headers, and the files or folders that may include them.
EXTERNAL = [
    (r"(hdf5|H5.*)\.h$", ("runtime/results/hdf5/",)),
    (r"^zlib", ("runtime/results/hdf5/", "library/meshes/importer/")),
    (r"^assimp/", ("library/meshes/importer/",)),
    (r"^(urdf_\w+|console_bridge)/", ("library/robots/urdf.cc",)),
    (r"^pugixml", ("library/robots/xml.h",)),
    (r"^sqlite3", ("runtime/results/journal/database.",)),
    (r"yaml-cpp/", ("compiler/yaml/plan_yaml",)),
    (r"(^|/)(bt|Bullet|LinearMath)", ("runtime/engine/", "library/detectors/bullet/")),
    (r"^fcl/", ("library/detectors/third_party/fcl/",)),
    (r"^ode/", ("library/detectors/third_party/ode/",)),
    (r"^CGAL/", ("library/detectors/third_party/cgal/",)),
    (r"^embree", ("library/detectors/third_party/embree/",)),
    (r"^boost/", ("library/detectors/third_party/boost/",)),
    (r"^ccd/", ("library/detectors/third_party/ccd/",)),
    (r"^libqhull_r/", ("library/meshes/convex_hull.cc",)),
    (r"^png", ("library/terrain/png.cc",)),
    (r"^tiff", ("library/terrain/tiff.cc",)),
    (r"^CLI/", ("runtime/cli/",)),
    (r"^nlohmann/", ("compiler/plan/gltf_buffers.cc", "runtime/printers/", "runtime/editor/", "runtime/pages/serve/", "runtime/pages/view/", "runtime/cli/",
                     "library/meshes/importer/")),
    (r"^(fmt|Eigen)/", ("compiler/", "library/", "runtime/")),
]

# The interface that plug-ins are compiled against is installed, and its namespace is the project's.
NAMESPACE_OF = {"library/detectors/detector.h": "cdb"}


def namespace_of(file):
    folder = file.rsplit("/", 1)[0]
    if folder.startswith("library/detectors/third_party"):
        return "cdb::third_party"  # a folder for each library
    return NAMESPACE_OF.get(file, "cdb::" + folder.rsplit("/", 1)[-1])


def check_file(file, text, graph):
    folder = file.rsplit("/", 1)[0]
    top = file.split("/")[0]
    for bracket, header in INCLUDE.findall(text):
        if bracket == '"' and header.split("/")[0] in FOLDERS + ("tests",):
            other = header.rsplit("/", 1)[0]
            if other != folder:
                graph.setdefault(folder, {}).setdefault(other, f"{file} includes {header}")
            below = FOLDERS[: FOLDERS.index(top) + 1]
            if header.split("/")[0] not in below:
                yield f"{file}: {top} must not include {header}"
            if (other.split("/")[0] == "compiler" and top in ("library", "runtime")
                    and other not in CONTRACT and not (folder + "/").startswith(WHOLE_COMPILER)):
                yield f"{file}: {header} is inside the compiler; outside of it only {', '.join(CONTRACT)} are known"
            continue
        for pattern, places in EXTERNAL:
            if re.search(pattern, header) and not file.startswith(places):
                yield f"{file}: {header} belongs to {', '.join(places)}"
    for namespace in NAMESPACE.findall(text):
        if namespace != namespace_of(file):
            yield f"{file}: namespace {namespace} should be {namespace_of(file)}"


def between_rooms(graph):
    """The first include from each room of runtime to each other one, by the two rooms."""
    found = {}
    for folder, others in sorted(graph.items()):
        for other, include in sorted(others.items()):
            if folder.startswith("runtime/") and other.startswith("runtime/"):
                rooms = folder.split("/")[1], other.split("/")[1]
                if rooms[0] != rooms[1]:
                    found.setdefault(rooms, include)
    return found


def picture(rooms):
    """A flow chart of Mermaid, the top floor first, without the arrows that follow from others."""
    below = {a: {b for c, b in rooms if c == a} for a in FLOOR}

    def reaches(a, b):
        return b in below[a] or any(reaches(c, b) for c in below[a])

    lines = ["flowchart TD"]
    for floor, names in reversed(list(enumerate(FLOORS))):
        lines.append(f"  subgraph {floor + 1}")
        lines += [f"    {name}" for name in names]
        lines.append("  end")
    lines += [f"  {a} --> {b}" for a, b in sorted(rooms) if not any(reaches(c, b) for c in below[a])]
    return "\n".join(lines)


def check_citations():
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        print("skipped: the files that are cited, as git is not here")
        return
    files = subprocess.run(["git", "-C", ROOT, "ls-files"], capture_output=True, text=True, check=True).stdout.split()
    by_name = collections.defaultdict(list)
    for file in files:
        by_name[file.rsplit("/", 1)[-1]].append("/" + file)
    for file in files:
        if not file.endswith((".h", ".cc", ".js", ".md")) or file.startswith(("tests/golden/", "tests/fuzz/")):
            continue
        for number, line in enumerate((ROOT / file).read_text(encoding="utf-8").split("\n"), 1):
            if not file.endswith(".md"):
                line = line.partition("//")[2]
            for cited in CITED.findall(line):
                if cited not in FOREIGN and not any(other.endswith("/" + cited) for other in by_name[cited.rsplit("/", 1)[-1]]):
                    yield f"{file}:{number}: there is no {cited}"


def find_cycle(graph):
    """A list of folders each of which includes the next, the last the first; None where there is none."""
    done, path = set(), []

    def visit(folder):
        if folder in path:
            return path[path.index(folder):]
        if folder in done:
            return None
        path.append(folder)
        for other in graph.get(folder, {}):
            cycle = visit(other)
            if cycle:
                return cycle
        path.pop()
        done.add(folder)
        return None

    for folder in list(graph):
        cycle = visit(folder)
        if cycle:
            return cycle
    return None


def main():
    wrong, graph, seen = [], {}, 0
    in_folder = collections.Counter()
    for top in FOLDERS:
        for path in sorted((ROOT / top).rglob("*")):
            if path.suffix in (".h", ".cc"):
                seen += 1
                in_folder[path.parent.relative_to(ROOT).as_posix()] += 1
                wrong += check_file(path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8"), graph)
    wrong += [f"{folder}: {count} sources; at most {MOST_SOURCES}: divide it by purpose"
              for folder, count in sorted(in_folder.items()) if count > MOST_SOURCES]
    rooms = between_rooms(graph)
    if sys.argv[1:] == ["--picture"]:
        print(picture(rooms))
        return 0
    for (room, other), include in rooms.items():
        if FLOOR.get(room, -1) <= FLOOR.get(other, len(FLOORS)):
            wrong.append(f"{include}: {room} is not above {other}")
    if picture(rooms) not in (ROOT / "runtime/README.md").read_text(encoding="utf-8"):
        wrong.append("runtime/README.md: its picture is not the output of tests/layering_test.py --picture")
    wrong += check_citations()
    cycle = find_cycle(graph)
    if cycle:
        wrong.append("folders include each other:")
        wrong += [f"  {graph[a][b]}" for a, b in zip(cycle, cycle[1:] + cycle[:1])]
    print("\n".join(wrong) or f"{seen} files include only what is below them")
    return 1 if wrong or seen < 40 else 0


if __name__ == "__main__":
    sys.exit(main())
