"""The figures of a results file, as cdb computes them."""
import json
import os
import shutil
import subprocess


def find_cdb(cdb=None):
    """The program: `cdb`, else $CDB, else the one in PATH."""
    program = cdb or os.environ.get("CDB") or shutil.which("cdb")
    if not program:
        raise FileNotFoundError("cdb is not in PATH: name it by figures(file, cdb=…) or in $CDB")
    return program


class Figures:
    """The document of `cdb show --json` (`cdb doc document`)."""

    def __init__(self, document, file):
        self.document = document
        self.file = file
        self.axes = {axis["name"]: axis for axis in document["axes"]}
        self.points = document["points"]
        if isinstance(self.points["at"], dict):
            raise ValueError(f"{file} has more points than a figure shows: take a part, "
                             "figures(file, select=['quantity=100'])")

    @property
    def title(self):
        return self.document["title"]

    @property
    def conclusions(self):
        """What the sweep answers: (question, answer, certainty)."""
        return [(c["question"], c["answer"], c["certainty"]) for c in self.document["conclusions"]]

    @property
    def warnings(self):
        """What to know before quoting a figure, the worst first."""
        return [warning["text"] for warning in self.document["warnings"]]

    @property
    def axis_names(self):
        return list(self.axes)

    def places(self):
        """The place of each point: a dict of axis and value."""
        return [{name: axis["values"][i] for (name, axis), i in zip(self.axes.items(), at)}
                for at in self.points["at"]]

    def find(self, **wanted):
        """The indices of the points with these values: find(detector="dbvt")."""
        for name, value in wanted.items():
            if name not in self.axes:
                raise KeyError(f"there is no axis {name!r}; there are {', '.join(self.axes)}")
            if value not in self.axes[name]["values"]:
                raise KeyError(f"the axis {name!r} has no value {value!r}; it has "
                               f"{', '.join(map(str, self.axes[name]['values']))}")
        return [i for i, place in enumerate(self.places())
                if all(place[name] == value for name, value in wanted.items())]

    def label(self, axis):
        """The axis with its unit, for a plot."""
        unit = self.axes[axis]["unit"]
        return self.axes[axis]["label"] + (f", {unit}" if unit else "")

    def interval_words(self):
        """Which statistic, and how its interval was made."""
        return f"{self.document['statistic']} {self.document['interval']['text']}"


def figures(file, cdb=None, select=()):
    """What `cdb show --json` says of a results file. `select`: parts of it, ["quantity=100"]."""
    command = [find_cdb(cdb), "show", str(file), "--json"]
    for part in select:
        command += ["--select", part]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 3):  # 3: some run failed, which the document says
        raise RuntimeError(done.stderr.strip() or f"{command[0]} ended with {done.returncode}")
    return Figures(json.loads(done.stdout), str(file))
