"""Selects values by label in each group of a results file: labels.py netcdf4|h5netcdf FOLDER"""
import sys

import xarray

engine, folder = sys.argv[1:]
path = folder + "/out.h5"


def text_or_number(text):
    try:
        return float(text)
    except ValueError:
        return text


groups = {}
found = 0
with open(folder + "/labels.tsv", encoding="utf-8") as lines:
    for line in lines:
        name, *labels, wanted = line.rstrip("\n").split("\t")
        group, _, own = name.rpartition("/")
        if group not in groups:
            groups[group] = xarray.open_dataset(path, group=group or None, engine=engine)
        at = dict(label.split("=") for label in labels)
        data = groups[group]
        at = {axis: value if data[axis].dtype == object else float(value)
              for axis, value in at.items()}
        value = data[own].sel(at).item()
        assert value == text_or_number(wanted), (name, labels, value, wanted)
        found += 1
assert set(groups) == {"", "run", "accuracy", "accuracy/reference"}, groups
for group, data in groups.items():
    # An attribute of a dataset with this name would hide the variable.
    hidden = [name for name in data.variables if hasattr(xarray.Dataset, name)]
    assert not hidden, (group, hidden)
assert groups["accuracy"].sample.attrs["units"] == "s"
assert groups[""].attrs["Conventions"] == "CF-1.8"
print(engine, "found", found, "values by label")
