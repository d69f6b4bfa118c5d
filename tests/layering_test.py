#!/usr/bin/env python3
"""A folder knows only what stands left of it: reads the includes and says which go the wrong way.

dsl: the standard library. compiler: dsl and the library's catalogue. library: compiler's plan and its own.
runtime: plan and library. One file includes HDF5, one yaml-cpp; Bullet is of runtime/engine
alone, and each other library with detectors of its folder in library/detectors.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.M)

PLAN = {"compiler/calls.h", "compiler/capacity.h", "compiler/expectation.h", "compiler/metrics.h", "compiler/needs.h",
        "compiler/plan.h", "compiler/plan_yaml.h", "compiler/plugins.h", "compiler/reference.h", "compiler/schema.h", "compiler/sha256.h",
        "compiler/trace.h", "compiler/value.h"}

# What a folder may include of ours; a folder may always include itself.
ALLOWED = {
    "dsl": lambda path: False,
    "compiler": lambda path: path.startswith("dsl/") or path == "library/catalogue.h",
    "library": lambda path: path in PLAN or path in ("dsl/check.h", "compiler/sha256.h"),
    "runtime/measure": lambda path: path in PLAN or path == "dsl/check.h",
    "runtime/needs": lambda path: path in PLAN or path == "dsl/check.h" or path.startswith("library/"),
    "runtime/accuracy": lambda path: path in PLAN or path == "dsl/check.h"
    or path.startswith(("library/", "runtime/measure/")),
    "runtime/engine": lambda path: path in PLAN or path == "dsl/check.h"
    or path.startswith(("library/", "runtime/measure/", "runtime/needs/")),
    "runtime/store": lambda path: path in PLAN or path == "dsl/check.h"
    or path.startswith("runtime/measure/"),
    "runtime/schedule": lambda path: path in PLAN or path == "dsl/check.h"
    or path.startswith(("library/", "runtime/accuracy/", "runtime/measure/", "runtime/store/")),
    "runtime/cli": lambda path: path.startswith(
        ("dsl/", "compiler/", "library/catalogue.h", "library/layouts/", "library/scene_error.h",
         "runtime/measure/", "runtime/needs/", "runtime/schedule/", "runtime/store/")),
}

# Who may include what is not ours: a pattern of the header, and the files that may.
OUTSIDE = [
    (r"(hdf5|H5.*)\.h$", lambda file: file.startswith("runtime/store/hdf5_")),
    (r"yaml-cpp/", lambda file: file == "compiler/plan_yaml.cc"),
    (r"(^|/)(bt|Bullet|LinearMath)", lambda file: file.startswith(("runtime/engine/", "library/detectors/bullet/"))),
    (r"^fcl/", lambda file: file.startswith("library/detectors/fcl/")),
    (r"^ode/", lambda file: file.startswith("library/detectors/ode/")),
    (r"^CGAL/", lambda file: file.startswith("library/detectors/cgal/")),
    (r"^embree", lambda file: file.startswith("library/detectors/embree/")),
    (r"^boost/", lambda file: file.startswith("library/detectors/boost/")),
    (r"^ccd/", lambda file: file.startswith("library/detectors/ccd/")),
    (r"^(hacd|meshoptimizer)", lambda file: file == "library/meshes/decompose.cc"),
    (r"^libqhull_r/", lambda file: file == "library/meshes/convex_hull.cc"),
    (r"^(CLI/|nlohmann/)", lambda file: file.startswith("runtime/cli/")),
    (r"^(fmt|Eigen)/", lambda file: not file.startswith("dsl/")),
]


def main():
    wrong, seen = [], 0
    for folder in ("dsl", "compiler", "library", "runtime"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix not in (".h", ".cc"):
                continue
            seen += 1
            file = path.relative_to(ROOT).as_posix()
            layer = max((l for l in ALLOWED if file.startswith(l + "/")), key=len)
            for bracket, header in INCLUDE.findall(path.read_text(encoding="utf-8")):
                ours = header.split("/")[0] in ("dsl", "compiler", "library", "runtime", "tests")
                if bracket == '"' and ours:
                    if not header.startswith(layer + "/") and not ALLOWED[layer](header):
                        wrong.append(f"{file}: {layer} must not know {header}")
                for pattern, may in OUTSIDE:
                    if re.search(pattern, header) and not ours and not may(file):
                        wrong.append(f"{file}: {header} is not for this file")
    print("\n".join(wrong) or f"{seen} files look only to their left")
    return 1 if wrong or seen < 40 else 0


if __name__ == "__main__":
    sys.exit(main())
