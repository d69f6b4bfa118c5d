#!/usr/bin/env python3
"""Damaged results files, under every command that reads them: each ends by itself, in time and within its memory.

  damage_test.py CDB [COUNT [SEED]]

Makes COUNT damaged copies of results files and shards: flipped bytes, files cut short, blocks that are swapped, zeroed or
repeated, and, where h5py is installed, arrays and attributes with other shapes, types and values. Half of them get their seal
anew, so that readers go past it. What a command does with a copy is one of

  refused   a message, and exit status 1 to 3
  same      exit status 0, and the text of the undamaged file
  other     exit status 0, and another text: of values that may well be, as the seal of these copies is good
  died      by a signal, or with another exit status
  hung      longer than 20 s
  silent    an exit status other than 0 without a message

Fails if anything died, hung or was silent, or if a copy with a broken seal was `other` under `cdb check`.
"""
import collections
import pathlib
import random
import resource
import shutil
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
PRIME = 0x9E3779B97F4A7C15
MASK = (1 << 64) - 1
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


def sealed(data):
    """With a seal that fits (runtime/store/seal.h)."""
    value = len(data) * PRIME & MASK
    padded = data + bytes(-len(data) % 8)
    for (word,) in struct.iter_unpack("<Q", padded):
        value = (value ^ word) * PRIME & MASK
        value = (value << 29 | value >> 35) & MASK
    return data + b"cdb seal" + struct.pack("<QQ", len(data), value ^ value >> 32)


def damaged_bytes(data, chance):
    data = bytearray(data)
    kind = chance.randrange(6)
    at = chance.randrange(len(data))
    length = chance.choice([1, 4, 8, 64, 512])
    if kind <= 1:
        for _ in range(chance.choice([1, 1, 2, 8])):
            data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    elif kind == 2:
        del data[max(at, 16):]
    elif kind == 3:
        data[at:at + length] = bytes([chance.choice([0, 255])]) * len(data[at:at + length])
    elif kind == 4:
        other = chance.randrange(len(data))
        data[at:at + length] = data[other:other + len(data[at:at + length])]
    else:
        value = chance.choice([0, 1, 2**31 - 1, 2**32 - 1, 2**63 - 1, 2**64 - 1, 2**40])
        at -= at % 4
        data[at:at + 8] = struct.pack("<Q", value)[:len(data[at:at + 8])]
    return bytes(data)


def damage_structure(path, chance):
    """Through HDF5 itself: a file that is whole, and says what cannot be."""
    with h5py.File(path, "r+") as file:
        names = []
        file.visit(names.append)
        name = chance.choice(names)
        thing = file[name]
        kind = chance.randrange(7)
        if kind == 0 or not isinstance(thing, h5py.Dataset):
            if chance.random() < 0.5 and len(thing.attrs) > 0:
                key = chance.choice(list(thing.attrs))
                del thing.attrs[key]
                if chance.random() < 0.7:
                    thing.attrs[key] = chance.choice([-1, 1e300, "x" * 70000, numpy.zeros(0), [1, 2, 3]])
            else:
                del file[name]
            return
        attributes = {key: thing.attrs[key] for key in thing.attrs if key not in ("DIMENSION_LIST", "REFERENCE_LIST")}
        shape, dtype = thing.shape, thing.dtype
        if kind == 1 and shape:
            shape = tuple(chance.choice([0, 1, n, n + 1, max(n - 1, 0), 3 * n]) for n in shape)
        elif kind == 2:
            shape = shape + (2,)
        elif kind == 3 and shape:
            shape = shape[1:]
        elif kind == 4:
            dtype = chance.choice(["i1", "u8", "f4", "f8", "S5", h5py.string_dtype()])
        elif kind == 5 and shape:
            shape = tuple(2**40 for _ in shape)
        else:
            if dtype.kind in "if" and thing.size:
                values = thing[...]
                values.flat[chance.randrange(values.size)] = chance.choice([-1, 127, 0, -2**7])
                if dtype.kind == "f":
                    values.flat[chance.randrange(values.size)] = chance.choice(
                        [float("nan"), float("inf"), -1.0, 1e308, -1e-300])
                thing[...] = values
            return
        del file[name]
        if kind == 5 or chance.random() < 0.05:
            file[name] = h5py.ExternalLink("other.h5", "/x") if chance.random() < 0.3 else numpy.zeros(1)
            if kind == 5:
                del file[name]
                file.create_dataset(name, shape, dtype if dtype.kind in "if" else "i4", chunks=tuple(16 for _ in shape) or None)
        else:
            file.create_dataset(name, shape, dtype)
        for key, value in attributes.items():
            try:
                file[name].attrs[key] = value
            except (TypeError, OSError, RuntimeError):
                pass


def limited():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def run(command, folder, has_limit):
    try:
        end = subprocess.run(command, cwd=folder, capture_output=True, timeout=TIMEOUT, check=False, stdin=subprocess.DEVNULL,
                             preexec_fn=limited if has_limit else None)
    except subprocess.TimeoutExpired:
        return "hung", b""
    text = end.stdout + end.stderr
    if end.returncode == 0:
        return "ended", end.stdout
    if end.returncode not in (1, 2, 3, 4):
        return "died", text
    return ("refused" if text.strip() else "silent"), text


def main():
    cdb = str(pathlib.Path(sys.argv[1]).resolve())
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 56
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else 1
    has_limit = b"__asan" not in pathlib.Path(cdb).read_bytes()  # it reserves more than there is
    commands = {
        "show": lambda file: [cdb, "show", file],
        "show --error": lambda file: [cdb, "show", file, "--error", "energy"],
        "show --json": lambda file: [cdb, "show", file, "--json"],
        "check": lambda file: [cdb, "check", file],
        "compare": lambda file: [cdb, "compare", "whole.h5", file],
        "report": lambda file: [cdb, "report", file, "-o", "report.html"],
        "view": lambda file: [cdb, "view", file, "-o", "view.html"],
    }
    counts = {name: collections.Counter() for name in [*commands, "merge"]}
    faults = []
    with tempfile.TemporaryDirectory() as place:
        place = pathlib.Path(place)
        originals = []
        for name, more in [("plain", ""), ("errors", ERRORS)]:
            (place / f"{name}.cdb").write_text(SWEEP % more, encoding="utf-8")
            subprocess.run([cdb, "run", "-q", f"{name}.cdb", "-o", f"{name}.h5"], cwd=place, check=True)
            originals.append(place / f"{name}.h5")
        for part in ("1/2", "2/2"):
            subprocess.run([cdb, "run", "-q", "plain.cdb", "-o", "parts.h5", "--shard", part], cwd=place, check=True)
        shards = sorted((place / "parts.runs").glob("*.h5"))
        expected = {}
        for original in originals:
            for name, command in commands.items():
                shutil.copy(original, place / "whole.h5")
                shutil.copy(original, place / "damaged.h5")
                expected[original, name] = run(command("damaged.h5"), place, has_limit)[1]
        for number in range(count):
            chance = random.Random(f"{seed} {number}")
            is_shard = number % 7 == 6
            original = chance.choice(shards if is_shard else originals)
            damaged = place / "damaged.h5"
            shutil.copy(original, damaged)
            is_sealed = number % 2 == 0
            if h5py is not None and number % 4 == 0:
                try:
                    damaged.write_bytes(damaged.read_bytes()[:-24])
                    damage_structure(damaged, chance)
                except Exception:  # h5py may refuse what it is asked for
                    pass
                damaged.write_bytes(sealed(damaged.read_bytes()) if is_sealed else damaged.read_bytes())
            else:
                whole = damaged.read_bytes()
                damaged.write_bytes(sealed(damaged_bytes(whole[:-24], chance)) if is_sealed else damaged_bytes(whole, chance))
            kept = damaged.read_bytes()
            is_same = kept == original.read_bytes()
            if is_shard:
                folder = place / "merge"
                shutil.rmtree(folder, ignore_errors=True)
                shutil.copytree(place / "parts.runs", folder / "parts.runs")
                (folder / "parts.runs" / original.name).write_bytes(kept)
                tried = {"merge": ([cdb, "merge", "parts.runs", "-o", "out.h5"], folder)}
            else:
                shutil.copy(original, place / "whole.h5")
                tried = {name: (command("damaged.h5"), place) for name, command in commands.items()}
            for name, (command, folder) in tried.items():
                end, text = run(command, folder, has_limit)
                if end == "ended":
                    end = "same" if is_shard or text == expected[original, name] else "other"
                counts[name][end] += 1
                bad = end in ("died", "hung", "silent") or (
                    name == "check" and not is_sealed and not is_same and end in ("same", "other"))
                if bad:
                    faults.append((number, name, end, text[-600:]))
                    shutil.copy(damaged, f"damaged_{number}.h5")
    kinds = ["refused", "same", "other", "died", "hung", "silent"]
    print(f"{'':14}" + "".join(f"{kind:>9}" for kind in kinds))
    for name, of in counts.items():
        print(f"{name:14}" + "".join(f"{of[kind]:9}" for kind in kinds))
    for number, name, end, text in faults[:20]:
        print(f"\ncopy {number} under {name}: {end}\n{text.decode(errors='replace')}")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
