"""Holds a results file against what is known of it: check.py h5py|xarray|netCDF4 FOLDER"""
import sys

import numpy as np


def h5py_reader(path):
    import h5py
    file = h5py.File(path)

    def read(name):
        data = file[name]
        return data.asstr()[()] if data.dtype == object else data[()]

    assert file.attrs["title"].decode() == "A plan for tests – µ", file.attrs["title"]
    assert [d[0].name for d in file["duration"].dims][-3:] == ["/rep", "/phase", "/cycle"]
    assert file["provenance/plan_text"].asstr()[()].startswith("# A cdb plan")
    return read


def xarray_reader(path):
    import xarray
    data = xarray.open_dataset(path)
    groups = {group: xarray.open_dataset(path, group=group) for group in ("run", "accuracy")}
    assert data.duration.dims == ("quantity", "size", "detector", "rep", "phase", "cycle")
    assert data.duration.dtype == np.float64 and data.status.dtype == np.int8
    started = groups["run"].started
    assert str(started.dtype).startswith("datetime64"), started.dtype
    assert data.sel(quantity=30, size=1.25, detector="dbvt", rep=1).n_cycles == 5

    def read(name):
        group, _, own = name.rpartition("/")
        return groups.get(group, data)[own].values

    return read


def netcdf4_reader(path):
    import netCDF4
    file = netCDF4.Dataset(path)
    assert file.variables["size"].units == "m"
    assert file.groups["provenance"].cpu == "a µ-processor"
    return lambda name: file[name][...]


def expected(path):
    with open(path, encoding="utf-8") as lines:
        for line in lines:
            name, shape, *values = line.rstrip("\n").split("\t")
            yield name, tuple(map(int, shape.split())), values


reader, folder = sys.argv[1:]
read = {"h5py": h5py_reader, "xarray": xarray_reader, "netCDF4": netcdf4_reader}[reader](
    folder + "/out.h5")
arrays = 0
for name, shape, values in expected(folder + "/numbers.tsv"):
    found, wanted = read(name), np.array(values, float)
    assert found.shape == shape, (name, found.shape, shape)
    found = np.ma.filled(np.ma.asarray(found, float), np.nan).ravel()
    # A reader may show the fill value -1 of integers as no value.
    same = (found == wanted) | (np.isnan(found) & (np.isnan(wanted) | (wanted == -1)))
    assert same.all(), (name, found[~same], wanted[~same])
    arrays += 1
for name, shape, values in expected(folder + "/texts.tsv"):
    found = np.asarray(read(name), dtype=object)
    assert found.shape == shape, (name, found.shape, shape)
    assert [str(text) for text in found.ravel()] == values, (name, found)
    arrays += 1
assert arrays >= 54, arrays
print(reader, "read", arrays, "arrays")
