#!/usr/bin/env python3
"""Writes cave.binvox: a cave of 40 x 20 x 40 cells of 0.1 m, with a rough floor, pillars, a hole in its roof and an open corner.

  make_cave.py cave.binvox
"""
import sys

COLUMNS, HEIGHT, ROWS = 40, 20, 40


def noise(x, z):
    """A hash of a place, from 0 to 3."""
    value = (x // 2 * 73856093 ^ z // 2 * 19349663) & 0xffffffff
    return (value * 2654435761 & 0xffffffff) >> 30


def is_solid(x, y, z):
    right, back = x - 19.5, z - 19.5
    away = right * right + back * back
    floor = 2 + noise(x, z) // 2 + int(away / 90)
    roof = 17 - int(away / 60) + noise(x + 7, z + 3) // 2
    if x > 19 and z > 19 and y > 6:
        return False  # a quarter is cut away, to look in
    if y < floor or away > 19 * 19:
        return True
    for at_x, at_z, radius in ((12, 14, 2), (27, 24, 3), (15, 28, 2)):
        # A pillar is wider at both ends.
        wide = radius + max(0, abs(y - 9) - 5)
        if (x - at_x) ** 2 + (z - at_z) ** 2 < wide * wide:
            return True
    return y >= roof and away > 7 * 7  # the hole is in the middle


def main():
    runs = []
    for x in range(COLUMNS):
        for z in range(ROWS):
            for y in range(HEIGHT):
                value = int(is_solid(x, y, z))
                if runs and runs[-1][0] == value and runs[-1][1] < 255:
                    runs[-1][1] += 1
                else:
                    runs.append([value, 1])
    header = f"#binvox 1\ndim {COLUMNS} {ROWS} {HEIGHT}\ntranslate -2 0 -2\nscale 4\ndata\n"
    with open(sys.argv[1], "wb") as out:
        out.write(header.encode() + b"".join(bytes(run) for run in runs))


if __name__ == "__main__":
    main()
