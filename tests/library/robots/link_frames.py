#!/usr/bin/env python3
"""Prints the frame of each link of a URDF file, and its mass, centre of mass and inertia: `link_frames.py ROBOT.urdf
[JOINT=POSITION]…`, a line for each link, with 3 numbers of the origin, 9 of the axes (rows of the matrix), the mass, 3
numbers of the centre and 9 of the tensor, all in the frame of the root link. Knows nothing of cdb."""
import math
import sys
import xml.etree.ElementTree as ElementTree

IDENTITY = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]


def times(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def apply(a, v):
    return [sum(a[i][k] * v[k] for k in range(3)) for i in range(3)]


def transposed(a):
    return [list(row) for row in zip(*a)]


def about(axis, angle):
    """Rodrigues' formula."""
    length = math.sqrt(sum(x * x for x in axis))
    x, y, z = (part / length for part in axis)
    c, s = math.cos(angle), math.sin(angle)
    return [[c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s],
            [y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s],
            [z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c)]]


def numbers(text):
    return [float(number) for number in text.split()]


def pose(element):
    """Fixed axes: roll about x, then pitch about y, then yaw about z."""
    origin = element.find("origin") if element is not None else None
    if origin is None:
        return [0.0, 0.0, 0.0], IDENTITY
    roll, pitch, yaw = numbers(origin.get("rpy", "0 0 0"))
    turn = times(about([0, 0, 1], yaw), times(about([0, 1, 0], pitch), about([1, 0, 0], roll)))
    return numbers(origin.get("xyz", "0 0 0")), turn


def together(a, b):
    return [x + y for x, y in zip(a[0], apply(a[1], b[0]))], times(a[1], b[1])


def moved(joint, position):
    axis = numbers(joint.find("axis").get("xyz")) if joint.find("axis") is not None else [1.0, 0.0, 0.0]
    if joint.get("type") in ("revolute", "continuous"):
        return [0.0, 0.0, 0.0], about(axis, position)
    if joint.get("type") == "prismatic":
        length = math.sqrt(sum(x * x for x in axis))
        return [position * x / length for x in axis], IDENTITY
    return [0.0, 0.0, 0.0], IDENTITY


def main():
    robot = ElementTree.parse(sys.argv[1]).getroot()
    positions = {name: float(value) for name, value in (word.split("=") for word in sys.argv[2:])}
    holders = {joint.find("child").get("link"): joint for joint in robot.findall("joint")}

    def frame(link):
        if link not in holders:
            return [0.0, 0.0, 0.0], IDENTITY
        joint = holders[link]
        at_joint = together(frame(joint.find("parent").get("link")), pose(joint))
        return together(at_joint, moved(joint, positions.get(joint.get("name"), 0.0)))

    for link in robot.findall("link"):
        where = frame(link.get("name"))
        inertial = link.find("inertial")
        mass, centre, tensor = 0.0, [0.0, 0.0, 0.0], [[0.0] * 3] * 3
        if inertial is not None:
            mass = float(inertial.find("mass").get("value"))
            centre, turn = together(where, pose(inertial))
            given = {key: float(value) for key, value in inertial.find("inertia").items()}
            tensor = [[given["i" + "".join(sorted("xyz"[i] + "xyz"[j]))] for j in range(3)] for i in range(3)]
            tensor = times(turn, times(tensor, transposed(turn)))
        rows = where[0] + sum(where[1], []) + [mass] + centre + sum(tensor, [])
        print(link.get("name"), *(repr(float(number)) for number in rows))


main()
