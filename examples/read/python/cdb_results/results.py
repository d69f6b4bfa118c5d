"""The numbers of a results file."""
import xarray


class Results:
    """The groups of a results file as xarray datasets. `cdb doc results` describes every array.

    data: duration in ns, pairs, contacts, status, verdict …
    run: facts of each run; accuracy: errors, or None where the scenario asks for none
    """

    def __init__(self, file):
        self.file = str(file)
        self.data = xarray.open_dataset(file)
        self.run = xarray.open_dataset(file, group="run")
        try:
            self.accuracy = xarray.open_dataset(file, group="accuracy")
        except OSError:
            self.accuracy = None

    @property
    def title(self):
        return self.data.attrs["title"]

    @property
    def axes(self):
        """The names of the sweep's axes."""
        return self.data.attrs["axes"].split()

    def time(self, phase="step"):
        """The time of each cycle, ns: the median over the repeats."""
        return self.data.duration.sel(phase=phase).median("rep")

    def __repr__(self):
        grid = " x ".join(f"{self.data.sizes[axis]} {axis}" for axis in self.axes)
        return f"<cdb results of {self.title!r}: {grid or 'one configuration'}>"


def open(file):
    """Opens a results file."""
    return Results(file)
