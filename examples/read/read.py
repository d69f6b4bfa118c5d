#!/usr/bin/python3
"""Median step time of every cell of a results file: read.py OUT.h5 [h5py|xarray]"""
import sys
import numpy as np

def with_h5py(path):
    import h5py
    with h5py.File(path) as file:
        axes = file.attrs["axes"].split()
        values = [file[a].asstr()[:] if file[a].dtype == object else file[a][:] for a in axes]
        step = list(file["phase"].asstr()).index("step")
        for at in np.ndindex(*map(len, values)):
            ns = file["duration"][at][:, step, :]  # axes…, rep, phase, cycle
            if not np.isnan(ns).all():
                print(*(v[i] for v, i in zip(values, at)), np.nanmedian(ns), sep="\t")

def with_xarray(path):
    import xarray
    data = xarray.open_dataset(path)  # group="run": host, peak_rss, …; group="accuracy": errors
    median = data.duration.sel(phase="step").median(["rep", "cycle"])
    print(median.drop_vars("phase").to_series().dropna().to_csv(sep="\t", header=False), end="")

with_xarray(sys.argv[1]) if sys.argv[2:] == ["xarray"] else with_h5py(sys.argv[1])
