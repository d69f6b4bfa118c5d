#!/usr/bin/env python3
"""Compares the numbers that cdb reads from tables with those that Python wrote, in many dialects, by the csv module and,
if it is installed, h5py.

  tables_test.py CDB
"""
import csv
import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile

DIALECTS = [dict(delimiter=d, quoting=q, lineterminator=t)
            for d in ",;\t" for q in (csv.QUOTE_MINIMAL, csv.QUOTE_ALL, csv.QUOTE_NONNUMERIC) for t in ("\n", "\r\n")]
UNITS = {"": 1, " [mm]": 1e-3, " (cm)": 1e-2, " [m]": 1, " [g]": 1e-3, " (kg)": 1}
TEXTS = ["", "a;b", "say \"x\"", "1,5", "two\nlines", "n #3", "2024-05-06 12:00:00", "  "]


def run(*arguments, folder):
    return subprocess.run([cdb, *arguments], cwd=folder, capture_output=True, text=True, timeout=300)


def write_table(path, generator):
    """Writes a table with a column of numbers among others; its values in SI units and the call that reads it."""
    dialect, comma = generator.choice(DIALECTS), generator.random() < 0.5
    width, place = generator.randint(1, 5), 0
    place = generator.randrange(width)
    unit = generator.choice(list(UNITS))
    values = [generator.choice((round(generator.uniform(0.001, 3000), generator.randint(1, 9)),
                                generator.randint(1, 3000), generator.uniform(1e-9, 1e9))) for _ in range(generator.randint(2, 9))]
    values[0] = 0.5  # so that a decimal comma is not one of thousands
    comma = comma and (dialect["delimiter"] != "," or dialect["quoting"] != csv.QUOTE_NONNUMERIC)
    written = [repr(v).replace(".", ",") if comma else v for v in values]
    heading = generator.choice(("d", "pos.x", "a \"b\" c", "x, y")) + unit
    headings = [heading if i == place else f"other {i}" for i in range(width)]
    with open(path, "w", newline="", encoding=generator.choice(("utf-8", "utf-8-sig"))) as file:
        writer = csv.writer(file, **dialect)
        writer.writerow(headings)
        for value in written:
            writer.writerow([value if i == place else generator.choice(TEXTS) for i in range(width)])
    quoted = heading.replace("\\", "\\\\").replace('"', '\\"')
    named = f'column: "#{place + 1}"' if generator.random() < 0.3 else f'column: "{quoted}"'
    if width == 1 or heading.startswith("x, y") or generator.random() < 0.3:  # otherwise refused, or recognised
        named += {",": ", separator: comma", ";": ", separator: semicolon", "\t": ", separator: tab"}[dialect["delimiter"]]
        named += f", decimal: {'comma' if comma else 'point'}"
    with open(path, newline="", encoding="utf-8-sig") as file:
        read = [row[place] for row in csv.reader(file, delimiter=dialect["delimiter"])][1:]
    read = [float(text.replace(",", ".")) for text in read]
    assert read == [float(v) for v in values], path
    return [v * UNITS[unit] for v in read], f'empirical("{path.name}", {named})', unit


def compare_csv(folder, count):
    generator, wanted = random.Random(5), {}
    text = "benchmark b {\n"
    for i in range(count):
        values, call, unit = write_table(folder / f"{i}.csv", generator)
        parameter = "size" if "m" in unit else "mass"
        text += f"objects g{i} {{ quantity 0; {parameter} {call} }}\n"
        wanted[f"g{i}"] = values
    (folder / "b.cdb").write_text(text + "}\n")
    plan = run("plan", "b.cdb", "-o", "b.yaml", folder=folder)
    assert plan.returncode == 0, plan.stderr[:3000]
    written = (folder / "b.yaml").read_text()
    for name, values in wanted.items():
        found = re.search(rf"name: {name}\n.*?empirical: \[(.*?)\]", written, re.S)
        numbers = [float(v) for v in found.group(1).split(",") if re.fullmatch(r"\s*[-+.\deE]+\s*", v)]
        assert len(numbers) == len(values), (name, found.group(1), values)
        for a, b in zip(numbers, values):
            assert math.isclose(a, b, rel_tol=1e-14), (name, a, b)


def compare_paths(folder):
    import h5py
    import numpy
    text = "benchmark p {{ objects {{ size 1; mass kinematic; location {} }} }}"
    times, places = numpy.array([5, 6, 8]), numpy.arange(9).reshape(3, 3)
    with h5py.File(folder / "path.h5", "w") as file:
        file["time"], file["position"] = times.astype(">i4"), places.astype("f4")
        file["log/all"] = numpy.column_stack([times * 1e9, places])[numpy.newaxis].astype("f8")
    with h5py.File(folder / "timeless.h5", "w") as file:
        file["position"] = places
    with h5py.File(folder / "fast.h5", "w") as file:
        file["time"], file["position"], file["linear_velocity"] = times, places, places
    hashes = set()
    for call in ('path("path.h5", start: first)',
                 'path("path.h5", start: first, columns: "t=/log/all[0,:,0] [ns], x=/log/all[0,:,1], y=/log/all[0,:,2], '
                 'z=/log/all[0,:,3]")'):
        (folder / "p.cdb").write_text(text.format(call))
        plan = run("plan", "p.cdb", "-o", "p.yaml", folder=folder)
        assert plan.returncode == 0, (call, plan.stderr)
        hashes.add(re.search(r'sha256: "(\w+)"', (folder / "p.yaml").read_text()).group(1))
    assert len(hashes) == 1, hashes
    for name, message in (("timeless", "it has no dataset `time`"), ("fast", "a path has no `linear_velocity`")):
        (folder / "p.cdb").write_text(text.format(f'path("{name}.h5")'))
        check = run("check", "p.cdb", folder=folder)
        assert check.returncode == 1 and message in check.stderr, (name, check.stderr)


def compare_hdf5(folder):
    import h5py
    import numpy
    start = numpy.arange(12).reshape(4, 3) * 5
    turn = numpy.tile([1, 0, 0, 0], (4, 1))
    with h5py.File(folder / "own.h5", "w") as file:
        file["position"], file["orientation"] = start.astype(">i2"), turn.astype("<f4")
    with h5py.File(folder / "nested.h5", "w") as file:
        file["robot/base/position"] = (start * 1000).astype(">f8")
        file["log/table"] = numpy.array([tuple(row) for row in start], dtype=[("x", "u1"), ("y", ">f4"), ("z", "i8")])
    with h5py.File(folder / "matlab.mat.h5", "w") as file:
        file["position"] = start.T.astype("f8")
        file["position"].attrs["MATLAB_class"] = numpy.bytes_("double")
    with h5py.File(folder / "turned.h5", "w") as file:
        file["position"] = start.T
    with h5py.File(folder / "pandas.h5", "w") as file:  # as by df.to_hdf
        frame = file.create_group("df")
        frame.attrs["pandas_type"] = "frame"
        frame["block0_items"], frame["block0_values"] = numpy.array([b"x", b"y", b"z"]), start.astype("f8")
    calls = {
        "own": 'poses("own.h5")',
        "nested": 'poses("nested.h5", columns: "x=/robot/base/position[:,0] [mm], y=/robot/base/position[:,1] [mm], '
                  'z=robot/base/position[:,2] [mm]")',
        "member": 'poses("nested.h5", columns: "x=/log/table/x, y=/log/table/y, z=/log/table/z")',
        "matlab": 'poses("matlab.mat.h5")',
        "rows": 'poses("turned.h5", columns: "x=/position[0,:], y=/position[1,:], z=/position[2,:]")',
        "pandas": 'poses("pandas.h5", columns: "x=/df/block0_values[:,0], y=/df/block0_values[:,1], '
                  'z=/df/block0_values[:,2]")'}
    numpy.savetxt(folder / "same.csv", start, delimiter=",", header="x,y,z")
    hashes = set()
    for name, call in calls.items():
        (folder / "h.cdb").write_text(f"benchmark h {{ world.side 200; objects {{ size 1; location {call} }} }}")
        plan = run("plan", "h.cdb", "-o", "h.yaml", folder=folder)
        assert plan.returncode == 0, (name, plan.stderr)
        if name != "own":  # it has orientations, too
            hashes.add(re.search(r'sha256: "(\w+)"', (folder / "h.yaml").read_text()).group(1))
    assert len(hashes) == 1, hashes  # of the values
    refusals = {"turned": 'it has 3 rows and 4 columns: write it by f["position"] = position.T in Python',
                "pandas": 'from pandas, write h5py.File("start.h5", "w")["position"] = df[["x", "y", "z"]]',
                "nested": "it has /log/table (4 rows of x, y, z), /robot/base/position (4 x 3)"}
    for name, message in refusals.items():
        (folder / "h.cdb").write_text(f'benchmark h {{ objects {{ location poses("{name}.h5") }} }}')
        check = run("check", "h.cdb", folder=folder)
        assert check.returncode == 1 and message in check.stderr, (name, check.stderr)


cdb = str(pathlib.Path(sys.argv[1]).resolve())
with tempfile.TemporaryDirectory() as name:
    compare_csv(pathlib.Path(name), 300)
    try:
        import h5py  # noqa: F401
    except ImportError:
        sys.exit(0)
    compare_hdf5(pathlib.Path(name))
    compare_paths(pathlib.Path(name))
