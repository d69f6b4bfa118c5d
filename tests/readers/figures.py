"""What cdb_results draws against the numbers of the file: figures.py CDB ACCURACY.cdb FOLDER"""
import os
import subprocess
import sys

import matplotlib

matplotlib.use("Agg")
import numpy as np
import xarray

program, scenario, folder = sys.argv[1:]
sys.path.insert(0, os.path.join(os.path.dirname(scenario), "read", "python"))
import cdb_results as cdb

fixture = folder + "/out.h5"
figures, results = cdb.figures(fixture, cdb=program), cdb.open(fixture)
data = xarray.open_dataset(fixture)
checked = 0


def check(found, wanted):
    global checked
    found, wanted = np.asarray(found, float), np.asarray(wanted, float)
    assert found.shape == wanted.shape and found.size > 0, (found, wanted)
    assert np.allclose(found, wanted, rtol=6e-6, equal_nan=True), (found, wanted)
    checked += found.size


def save(ax, name):
    ax.figure.savefig(f"{folder}/figure_{name}.png", dpi=80)


# For points whose repeats are all sound, one line computes the statistic from the file.
assert figures.axis_names == ["quantity", "size", "detector"], figures.axis_names
whole = [i for i, n in enumerate(figures.points["repeats"]) if n == 2]
for phase in ("broad", "step"):
    means = [float(data.duration.sel({**place, "phase": phase}).median("rep").mean("cycle"))
             for place in (figures.places()[i] for i in whole)]
    check([figures.points["times"][phase]["mean"][i] for i in whole], means)

# The time of each cycle, drawn from the file.
ax = cdb.plot_phases(results, quantity=30, size=1.25, detector="dbvt")
at = data.duration.sel(quantity=30, size=1.25, detector="dbvt").median("rep")
unit = {"s": 1e9, "ms": 1e6, "us": 1e3, "ns": 1}[ax.get_ylabel().rsplit(" ", 1)[1]]
for line in ax.lines:
    check(line.get_ydata() * unit, at.sel(phase=line.get_label()))
assert [line.get_label() for line in ax.lines] == ["broad", "narrow", "solve", "integrate", "step"]
save(ax, "phases")

# A phase over an axis: the points of each line, and their intervals.
ax = cdb.plot_over(figures, "quantity", size=1.25)
unit = {"s": 1e9, "ms": 1e6, "us": 1e3, "ns": 1}[ax.get_ylabel().rsplit(" ", 1)[1]]
step = figures.points["times"]["step"]
for container in ax.containers:
    points = [i for i in figures.find(size=1.25, detector=container.get_label())
              if not figures.points["is_void"][i]]
    check(container.lines[0].get_xdata(), [figures.places()[i]["quantity"] for i in points])
    check(container.lines[0].get_ydata() * unit, [step["mean"][i] for i in points])
    ends = [segment[1][1] * unit for segment in container.lines[2][0].get_segments()]
    check(ends, [step["mean"][i] if step["high"][i] is None else step["high"][i] for i in points])
save(ax, "over")

ax = cdb.plot_ratios(figures)
means = [mean["value"] for mean in figures.document["ratios"]["means"]["step"]]
check([container.lines[0].get_xdata()[0] for container in ax.containers],
      [value for value in means if value is not None])
save(ax, "ratios")

ax = cdb.plot_stability(figures, "quantity", "detector")
shown = {(text.get_position()): text.get_text().split("\n")[0] for text in ax.texts[:-1]}
for i in figures.find(size=figures.axes["size"]["values"][0]):
    x, _, y = figures.points["at"][i]
    assert shown[(x, y)] == figures.points["verdict"][i], shown
    checked += 1
save(ax, "stability")

# Errors of a real scene.
result = folder + "/accuracy.h5"
subprocess.run([program, "run", "-q", "--fresh", "-b", "accuracy", "-o", result, scenario], check=True,
               stdout=subprocess.DEVNULL)
figures = cdb.figures(result, cdb=program)
errors = xarray.open_dataset(result, group="accuracy")
ax = cdb.plot_errors(figures, "position")
rows = figures.document["fronts"][0]["rows"]
check([c.lines[0].get_ydata()[0] for c in ax.containers], [row["error"] for row in rows])
check([row["error"] for row in rows],
      [float(errors.position.sel(row["at"]).squeeze()) for row in rows])
duration = xarray.open_dataset(result).duration.sel(phase="step")
# Runs at 60 Hz have the fewest cycles, so they are padded with NaN.
check([c.lines[0].get_xdata()[0] for c in ax.containers],
      [1e9 / float(duration.sel(row["at"]).median("rep").mean("cycle")) / row["at"]["hz"]
       for row in rows])
save(ax, "errors")

for wrong in (lambda: cdb.plot_errors(figures, "no"), lambda: cdb.plot_over(figures, "no")):
    try:
        wrong()
    except KeyError as error:
        assert "there is no" in str(error), error
    else:
        raise AssertionError("a wrong name was taken")
assert figures.conclusions and figures.conclusions[0][0].startswith("Which configuration")
print("checked", checked, "numbers of figures")
