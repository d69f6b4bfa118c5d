#!/usr/bin/env python3
"""Damaged results files, journals and traces, under every command that reads them: each command ends by itself, in time and
within its memory, and takes nothing for whole that is not.

  damage_test.py CDB [COUNT] [--seed N] [--jobs N] [--only N] [--list]

Makes COUNT damaged copies: flipped bytes, files cut short, blocks that are zeroed, swapped or overwritten by extreme numbers,
and, where h5py is installed, arrays, attributes, texts and links with other shapes, types and values; journals also get other
values in their tables. Half of the others get their seal anew, so that readers go past it. What a command does with a copy is one of

  refused   a message, and exit status 1 to 4
  same      exit status 0, and the text of the undamaged file
  other     exit status 0, and another text; --list names these, and the damage
  died      by a signal, or with another exit status
  hung      longer than 20 s
  memory    out of memory, at 2 GiB
  silent    an exit status other than 0 without a message

Fails if anything died, hung, ran out of memory or was silent, if a copy with a broken seal was taken, or if a number of a
damaged journal was taken that is not the one of the undamaged file. Copies with faults are
kept in the current folder; --only N makes copy N again.
"""
import argparse
import collections
import concurrent.futures
import contextlib
import os
import pathlib
import random
import resource
import shutil
import sqlite3
import struct
import subprocess
import sys
import tempfile

try:
    import h5py
    import numpy
except ImportError:
    h5py = None

TIMEOUT = 20
MEMORY = 2 << 30
SEAL_BYTES = 24
PRIME = 0x9E3779B97F4A7C15
MASK = (1 << 64) - 1
KINDS = ["refused", "same", "other", "died", "hung", "memory", "silent"]
SWEEP = """benchmark damaged "To be damaged" {
  cycles 12
  record timing, counts, energy, stability, poses
  repeats 2
  world.side 200
  objects { quantity sweep(3, 5); size 20; linear_velocity uniform(-20, 20) }
  detector sweep(dbvt, sap)
  %s
}
"""
ERRORS = """timestep 1 / 60
  sleeping off
  accuracy { reference { timestep 1 / 240 }
  metrics position, energy; interval 1 / 60 }"""
TRACED = """benchmark traced {
  cycles 12
  world.side 200
  objects { quantity 5; size 20; linear_velocity uniform(-20, 20) }
}
"""
ON_TRACE = 'benchmark on_trace { trace "damaged.h5"; detector sap }\n'
ON_PAIRS = 'benchmark on_pairs { trace "damaged.h5"; narrow_phase bullet }\n'
# {whole} and {damaged} stand for files.
COMMANDS = {
    "results": {
        "show": ["show", "{damaged}"],
        "show --all": ["show", "{damaged}", "--all"],
        "show --error": ["show", "{damaged}", "--error", "energy"],
        "show --json": ["show", "{damaged}", "--json"],
        "check": ["check", "{damaged}"],
        "compare": ["compare", "{whole}", "{damaged}"],
        "compare --json": ["compare", "{damaged}", "{whole}", "--json"],
        "report": ["report", "{damaged}", "-o", "report.html"],
        "view": ["view", "{damaged}", "-o", "view.html"],
        "view --gltf": ["view", "{damaged}", "--gltf", "view.glb"],
    },
    "journal": {"merge": ["merge", "parts.runs", "-o", "out.h5"], "show merged": ["show", "out.h5", "--csv"],
                "check": ["check", "{damaged}"]},
    "trace": {"run on trace": ["run", "-q", "on_trace.cdb", "-o", "out.h5"],
              "run on pairs": ["run", "-q", "on_pairs.cdb", "-o", "pairs.h5"], "check": ["check", "{damaged}"]},
}


def sealed(data):
    """With a seal that fits (runtime/results/files/seal.h)."""
    value = len(data) * PRIME & MASK
    padded = data + bytes(-len(data) % 8)
    for (word,) in struct.iter_unpack("<Q", padded):
        value = (value ^ word) * PRIME & MASK
        value = (value << 29 | value >> 35) & MASK
    return data + b"cdb seal" + struct.pack("<QQ", len(data), value ^ value >> 32)


def damage_bytes(data, chance):
    """The damaged bytes, and what was done."""
    data = bytearray(data)
    kind = chance.choice(["flip", "flip", "cut", "fill", "copy", "swap", "number"])
    at = chance.randrange(len(data))
    length = min(chance.choice([1, 4, 8, 64, 512, 4096]), len(data) - at)
    other = chance.randrange(len(data) - length + 1)
    if kind == "flip":
        for _ in range(chance.choice([1, 1, 2, 8])):
            data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    elif kind == "cut":
        del data[max(at, 16):]
    elif kind == "fill":
        data[at:at + length] = bytes([chance.choice([0, 255])]) * length
    elif kind == "copy":
        data[at:at + length] = data[other:other + length]
    elif kind == "swap":
        here, there = data[at:at + length], data[other:other + length]
        data[at:at + length], data[other:other + length] = there, here
    else:
        at -= at % 4
        value = chance.choice([0, 1, 2**31 - 1, 2**32 - 1, 2**63 - 1, 2**64 - 1, 2**40])
        data[at:at + 8] = struct.pack("<Q", value)[:len(data[at:at + 8])]
    return bytes(data), f"{kind} at {at}, {length} bytes"


def damage_attribute(thing, chance):
    key = chance.choice([key for key in thing.attrs if key not in ("DIMENSION_LIST", "REFERENCE_LIST")] or ["new"])
    if key in thing.attrs:
        del thing.attrs[key]
    if chance.random() < 0.3:
        return f"attribute {key} removed"
    value = chance.choice([-1, 2**31 - 1, 1e300, float("nan"), "", "x" * 60000, "\x1b[31m", numpy.zeros(0), [1, 2, 3],
                           h5py.Empty("f8")])
    thing.attrs[key] = value
    return f"attribute {key} = {str(value)[:20]!r}"


def damage_values(dataset, chance):
    """Impossible and extreme values, with the shape and type as they should be."""
    if dataset.dtype.kind == "O":
        value = chance.choice(["", "x" * 100000, "\x1b[31m", "<script>", b"\xff\xfe", "0" * 16])
        if dataset.shape == ():
            dataset[()] = value
        else:
            dataset[tuple(chance.randrange(n) for n in dataset.shape)] = value
        return f"text {str(value)[:20]!r}"
    values = dataset[...]
    if dataset.dtype.kind == "f":
        value = chance.choice([float("nan"), float("inf"), -float("inf"), -1.0, 0.0, 1e308, -1e-300, 5e-324, 1e19])
    else:
        value = chance.choice([-1, 0, 127, -128, numpy.iinfo(dataset.dtype).max, numpy.iinfo(dataset.dtype).min])
    if chance.random() < 0.3:
        values = numpy.full_like(values, value)
    else:
        flat = values.reshape(-1)
        flat[chance.randrange(flat.size)] = value
        values = flat.reshape(values.shape)
    dataset[...] = values
    return f"value {value}"


def remake_array(file, name, kind, chance):
    """The array `name` with another shape or type, and attributes as before."""
    thing = file[name]
    attributes = {key: thing.attrs[key] for key in thing.attrs if key not in ("DIMENSION_LIST", "REFERENCE_LIST")}
    shape, dtype, chunks = thing.shape, thing.dtype, None
    if kind == "shape":
        shape = tuple(chance.choice([0, 1, n, n + 1, max(n - 1, 0), 3 * n]) for n in shape) or (2,)
    elif kind == "rank":
        shape = shape[1:] if shape and chance.random() < 0.5 else shape + (chance.choice([1, 2]),)
    elif kind == "huge":
        size = chance.choice([2**20, 2**31 - 1, 2**40])
        shape = tuple(chance.choice([n, size]) for n in shape[:-1]) + (size,)
        chunks = tuple(chance.choice([1, 16, 256]) for _ in shape)
    else:
        dtype = numpy.dtype(chance.choice(["i1", "u8", "f4", "f8", ">f8", "c16", "S5", "?", h5py.string_dtype()]))
    del file[name]
    file.create_dataset(name, shape, dtype, chunks=chunks)
    for key, value in attributes.items():
        file[name].attrs[key] = value
    return f"{shape} of {dtype}"


def damage_structure(path, chance):
    """Through HDF5: a whole file, which says what cannot be. Returns what was done."""
    with h5py.File(path, "r+") as file:
        names = ["/"]
        file.visit(names.append)
        name = chance.choice(names)
        kind = chance.choice(["attribute", "removed", "shape", "rank", "type", "huge", "link", "value", "value", "value"])
        if name == "/" or kind == "attribute" or (kind not in ("removed", "link") and not isinstance(file[name], h5py.Dataset)):
            return f"{name}: {damage_attribute(file[name], chance)}"
        if kind == "removed":
            del file[name]
            return f"{name}: removed"
        if kind == "link":
            del file[name]
            other = chance.choice([h5py.ExternalLink("whole.h5", name), h5py.ExternalLink("/dev/zero", "x"),
                                   h5py.SoftLink("/" + name), h5py.SoftLink("/"), h5py.SoftLink("/nothing")])
            file[name] = other
            return f"{name}: {other}"
        if kind == "value":
            return f"{name}: {damage_values(file[name], chance)}" if file[name].size else "none"
        return f"{name}: {remake_array(file, name, kind, chance)}"


def damage_tables(path, chance):
    """Through SQLite: a whole file, whose rows are not as they were written."""
    with contextlib.closing(sqlite3.connect(path)) as file:
        table, column = chance.choice([("run", column) for column in ("id", "written", "about", "checksum", "facts", "chunks")] +
                                      [("about", "bytes"), ("asked", "value"), ("asked", "what")])
        value = chance.choice([0, -1, 2**63 - 1, 1.5, "", "x" * 1000, b"", bytes(100), chance.randbytes(5000)])
        kind = chance.choice(["value", "value", "value", "other", "delete", "drop", "pragma"])
        text = {"value": f"UPDATE {table} SET {column} = ? WHERE rowid = (SELECT rowid FROM {table} ORDER BY random() LIMIT 1)",
                "other": f"UPDATE {table} SET {column} = (SELECT {column} FROM {table} ORDER BY random() LIMIT 1)",
                "delete": f"DELETE FROM {table} WHERE rowid = (SELECT max(rowid) FROM {table})", "drop": f"DROP TABLE {table}",
                "pragma": f"PRAGMA {chance.choice(['application_id', 'user_version'])} = {chance.choice([0, 1, 2, -1])}"}[kind]
        try:
            file.execute(text, (value,) if kind == "value" else ())
            file.commit()
        except sqlite3.Error as error:
            return f"SQLite refuses it: {error}"
        return f"{text} {str(value)[:20]!r}"


def damage(path, number, seed, kind):
    """Damages the copy at `path`. Returns what was done, and whether its seal fits."""
    chance = random.Random(f"{seed} {number}")
    if kind == "journal":
        if chance.random() < 0.5:
            return damage_tables(path, chance), True
        data, text = damage_bytes(path.read_bytes(), chance)
        path.write_bytes(data)
        return text, True
    whole = path.read_bytes()
    seal = whole[-SEAL_BYTES:]
    is_sealed = number % 2 == 0
    if h5py is not None and number // 2 % 2 == 0:
        path.write_bytes(whole[:-SEAL_BYTES])
        try:
            text = damage_structure(path, chance)
        except (OSError, RuntimeError, TypeError, ValueError, KeyError, OverflowError) as error:
            text = f"h5py refuses it: {error}"
        path.write_bytes(sealed(path.read_bytes()) if is_sealed else path.read_bytes() + seal)
    else:
        data, text = damage_bytes(whole[:-SEAL_BYTES] if is_sealed else whole, chance)
        path.write_bytes(sealed(data) if is_sealed else data)
    return text, is_sealed or path.read_bytes() == whole


def run(command, folder, has_limit):
    def limit():
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if has_limit:
            resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))

    try:
        end = subprocess.run(command, cwd=folder, capture_output=True, timeout=TIMEOUT, check=False, stdin=subprocess.DEVNULL,
                             preexec_fn=limit)
    except subprocess.TimeoutExpired:
        return "hung", b""
    text = end.stdout + end.stderr
    if b"bad_alloc" in text or b"annot allocate" in text or b"out of memory" in text:
        return "memory", text
    if b"Sanitizer" in text or b"runtime error:" in text:
        return "died", text
    if end.returncode == 0:
        return "ended", end.stdout
    if end.returncode not in (1, 2, 3, 4):
        return "died", text + f"\nexit status {end.returncode}".encode()
    return ("refused" if text.strip() else "silent"), text


def make_originals(cdb, place):
    """The undamaged files, by kind."""
    texts = {"plain": SWEEP % "", "errors": SWEEP % ERRORS, "traced": TRACED, "on_trace": ON_TRACE, "on_pairs": ON_PAIRS}
    for name, text in texts.items():
        (place / f"{name}.cdb").write_text(text, encoding="utf-8")
    commands = [["run", "-q", name + ".cdb", "-o", name + ".h5"] for name in ("plain", "errors")]
    commands += [["run", "-q", "plain.cdb", "-o", "parts.h5", "--shard", part] for part in ("1/2", "2/2")]
    commands += [["trace", "-q", "--pairs", "traced.cdb", "-o", "trace.h5"]]
    for command in commands:
        subprocess.run([cdb, *command], cwd=place, check=True)
    return {
        "results": [place / "plain.h5", place / "errors.h5"],
        "journal": [place / "parts.runs" / "runs.journal"],
        "trace": [place / "trace.h5"],
    }


def set_up(place, kind, original):
    """A folder for the commands of `kind`; the place of the file to be damaged in it."""
    folder = pathlib.Path(tempfile.mkdtemp(dir=place))
    shutil.copy(original, folder / "whole.h5")
    if kind == "journal":
        shutil.copytree(place / "parts.runs", folder / "parts.runs")
        return folder / "parts.runs" / original.name
    for name in ("on_trace.cdb", "on_pairs.cdb"):
        shutil.copy(place / name, folder)
    shutil.copy(original, folder / "damaged.h5")
    return folder / "damaged.h5"


def try_file(cdb, kind, damaged, has_limit):
    """What each command does with it."""
    folder = damaged.parent.parent if kind == "journal" else damaged.parent
    names = {"damaged": damaged.relative_to(folder), "whole": "whole.h5"}
    return {name: run([cdb, *(word.format(**names) for word in words)], folder, has_limit)
            for name, words in COMMANDS[kind].items()}


def kind_of(number):
    """Of seven copies, one journal and one trace."""
    return {5: "trace", 6: "journal"}.get(number % 7, "results")


def has_fewer_runs(output, expected):
    """Every row is one of the undamaged file, of a run that is missing, or of fewer repeats."""
    head, *rows = expected.splitlines()
    columns = head.split(b",")
    verdict, repeats = columns.index(b"verdict"), columns.index(b"repeats")
    most = {tuple(row.split(b",")[:verdict]): int(row.split(b",")[repeats]) for row in rows}

    def is_of_fewer(row):
        cells = row.split(b",")
        return int(cells[repeats]) < most[tuple(cells[:verdict])]

    return output.splitlines()[0] == head and all(
        row in rows or b"missing" in row or is_of_fewer(row) for row in output.splitlines()[1:])


def try_copy(number, arguments, place, originals, expected, has_limit):
    """The counts, the faults and the files taken of copy `number`."""
    kind = kind_of(number)
    original = random.Random(number).choice(originals[kind])
    damaged = set_up(place, kind, original)
    text, has_good_seal = damage(damaged, number, arguments.seed, kind)
    kept = damaged.read_bytes()
    is_whole = kept == original.read_bytes()
    ends, faults, taken = [], [], []
    for name, (end, output) in try_file(arguments.cdb, kind, damaged, has_limit).items():
        if (original, name) not in expected:
            continue
        if end == "ended":
            end = "same" if output == expected[original, name] else "other"
            if not is_whole:
                taken.append(f"{number} {kind} {name}: {end}: {text}")
        ends.append((f"{kind}: {name}", end))
        is_wrong = name == "show merged" and end == "other" and not has_fewer_runs(output, expected[original, name])
        if end in KINDS[3:] or is_wrong or (not has_good_seal and end in ("same", "other")):
            faults.append(f"copy {number} ({kind}, {text}) under {name}: {end}\n{output[-800:].decode(errors='replace')}")
    if faults:
        pathlib.Path(f"damaged_{arguments.seed}_{number}.h5").write_bytes(kept)
    shutil.rmtree(place / damaged.relative_to(place).parts[0])
    return ends, faults, taken


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("cdb", type=lambda path: str(pathlib.Path(path).resolve()))
    parser.add_argument("count", type=int, nargs="?", default=56)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--only", type=int)
    parser.add_argument("--list", action="store_true")
    arguments = parser.parse_args()
    has_limit = b"__asan" not in pathlib.Path(arguments.cdb).read_bytes()  # AddressSanitizer reserves more memory than there is
    counts, faults = collections.defaultdict(collections.Counter), []
    with tempfile.TemporaryDirectory() as place:
        place = pathlib.Path(place)
        (place / "leaks").write_text("leak:libhdf5\n", encoding="utf-8")  # HDF5 does not always free memory after a failed read
        os.environ["LSAN_OPTIONS"] = f"suppressions={place}/leaks:print_suppressions=0"
        originals = make_originals(arguments.cdb, place)
        expected = {}
        for kind, files in originals.items():
            for original in files:
                for name, (end, output) in try_file(arguments.cdb, kind, set_up(place, kind, original), has_limit).items():
                    if end == "ended":  # excludes `show --error` without errors
                        expected[original, name] = output
        numbers = range(arguments.count) if arguments.only is None else [arguments.only]
        with concurrent.futures.ProcessPoolExecutor(arguments.jobs) as pool:
            tried = [pool.submit(try_copy, number, arguments, place, originals, expected, has_limit) for number in numbers]
            for done in tried:
                ends, more_faults, taken = done.result()
                for name, end in ends:
                    counts[name][end] += 1
                faults += more_faults
                if arguments.list:
                    print(*taken, sep="\n", end="\n" if taken else "")
    print(f"{'':24}" + "".join(f"{end:>9}" for end in KINDS))
    for name, of in sorted(counts.items()):
        print(f"{name:24}" + "".join(f"{of[end]:9}" for end in KINDS))
    print(*faults[:20], sep="\n\n")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
