"""Figures of results, one function each. Each takes what `figures()` or `open()` returns and returns
the axes of matplotlib. Colours are those of Okabe and Ito, which colour-blind readers can tell apart;
void points are hollow."""
import textwrap

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import FuncFormatter, NullLocator

COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"]
MARKERS = "osD^vPX"
VERDICT_COLOURS = ["#009E73", "#F0E442", "#E69F00", "#D55E00", "#CC79A7", "#0072B2", "#56B4E9",
                   "#999999", "#000000"]
# The phases of a cycle that add up to the step, nearly.
PARTS = ["broad", "narrow", "solve", "integrate"]
UNITS = [(1e9, "s"), (1e6, "ms"), (1e3, "us"), (1, "ns")]


def numbers(values):
    """A column as an array; NaN for null."""
    return np.array([np.nan if value is None else value for value in values], float)


def unit_of(values):
    """The unit in which the median of some times is read most easily: ns in it, and its name."""
    finite = np.asarray(values, float)
    finite = finite[np.isfinite(finite)]
    middle = np.median(finite) if finite.size else 1
    return next((unit for unit in UNITS if middle >= unit[0]), UNITS[-1])


def new_axes(ax, title):
    if ax is None:
        figure, ax = plt.subplots(figsize=(6.4, 4.6))
        figure.subplots_adjust(left=0.14, right=0.96, top=0.87, bottom=0.22)
    ax.set_title(title, fontsize="medium", loc="left")
    return ax


def foot(ax, text):
    """Below the figure: which statistic."""
    ax.annotate(textwrap.fill(text, 100), (0, 0), (0, -40), "axes fraction",
                textcoords="offset points", fontsize="x-small", color="#555555", va="top",
                annotation_clip=False)


def log_scale(axis):
    """Logarithmic, with plain numbers: at 1, 2 and 5 where it spans a decade."""
    def plain(value, _):
        low, high = axis.get_view_interval()
        return f"{value:g}" if high < 10 * low or f"{value:e}"[0] in "125" else ""
    getattr(axis.axes, f"set_{axis.axis_name}scale")("log")
    axis.set_major_formatter(FuncFormatter(plain))
    axis.set_minor_formatter(FuncFormatter(plain))
    axis.set_tick_params(which="both", labelsize="small")


def place_text(place, leave=()):
    return ", ".join(f"{name} {value:g}" if isinstance(value, (int, float)) else f"{name} {value}"
                     for name, value in place.items() if name not in leave)


def no_data(ax, text):
    ax.text(0.5, 0.5, text, transform=ax.transAxes, ha="center", va="center", color="#555555")
    ax.set_axis_off()
    return ax


def plot_phases(results, ax=None, phases=PARTS, **place):
    """The phases of one configuration over the cycles: plot_phases(cdb.open(f), detector="dbvt").
    Axes that are not named are at their first value."""
    data = results.data
    at = {axis: place.get(axis, data[axis].values[0]) for axis in results.axes}
    ax = new_axes(ax, results.title + (f"\n{place_text(at)}" if at else ""))
    if "duration" not in data:
        return no_data(ax, "no timings in this file")
    times = [results.time(phase).sel(at) for phase in [*phases, "step"]]
    if np.isnan(times[-1]).all():
        return no_data(ax, "no run of this configuration has cycles")
    ns, unit = unit_of(times[-1])
    for i, (phase, time) in enumerate(zip([*phases, "step"], times)):
        is_step = phase == "step"
        ax.plot(data.cycle, time / ns, label=phase, color="#000000" if is_step else COLOURS[i],
                linewidth=0.8 if is_step else 1.2, zorder=1 if is_step else 2)
    ax.set(xlabel="cycle", ylabel=f"time of a cycle, {unit}", ylim=(0, None))
    ax.legend(frameon=False, fontsize="small", ncols=len(times), loc="upper center")
    ax.set_ylim(0, 1.15 * ax.get_ylim()[1])
    foot(ax, "Median over the repeats.")
    return ax


def plot_over(figures, axis, ax=None, phase="step", colour=None, **place):
    """The mean time of a phase over an axis, with intervals; a line for each value of `colour`, by
    default of the detectors: plot_over(figures, "quantity"). `place` fixes other axes; those that
    are neither named nor fixed are at their first value."""
    figures.find(**{axis: figures.axes[axis]["values"][0]} if axis in figures.axes else {axis: None})
    detector = figures.document["detector_axis"]
    if colour is None and detector is not None and figures.axis_names[detector] != axis:
        colour = figures.axis_names[detector]
    fixed = {name: place.get(name, values["values"][0]) for name, values in figures.axes.items()
             if name not in (axis, colour)}
    ax = new_axes(ax, figures.title + (f"\n{place_text(fixed)}" if fixed else ""))
    if "times" not in figures.points:
        return no_data(ax, "no timings in this file")
    time = figures.points["times"][phase]
    mean, low, high = (numbers(time[name]) for name in ("mean", "low", "high"))
    void = np.array(figures.points["is_void"])
    ns, unit = unit_of(mean[figures.find(**fixed)])
    places = figures.places()
    lines = figures.axes[colour]["values"] if colour else [None]
    for i, value in enumerate(lines):
        at = figures.find(**fixed, **({colour: value} if colour else {}))
        x = np.array([places[p][axis] for p in at])
        y, style = mean[at] / ns, {"color": COLOURS[i % len(COLOURS)]}
        sides = np.abs(np.array([mean[at] - low[at], high[at] - mean[at]])) / ns
        sound = ~void[at]
        ax.errorbar(x[sound], y[sound], np.nan_to_num(sides[:, sound]), label=value, capsize=3,
                    marker=MARKERS[i % len(MARKERS)], markersize=5, **style)
        if (~sound).any():
            ax.plot(x[~sound], y[~sound], MARKERS[i % len(MARKERS)], mfc="none", **style)
    if not figures.axes[axis]["is_text"] and min(figures.axes[axis]["values"]) > 0:
        log_scale(ax.xaxis)
        log_scale(ax.yaxis)
        ax.set_xticks(figures.axes[axis]["values"],
                      [f"{value:g}" for value in figures.axes[axis]["values"]])
        ax.xaxis.set_minor_locator(NullLocator())
    ax.set(xlabel=figures.label(axis), ylabel=f"mean time of {phase}, {unit}")
    if colour:
        ax.legend(title=figures.axes[colour]["label"], frameon=False, fontsize="small")
    foot(ax, figures.interval_words())
    return ax


def plot_ratios(figures, ax=None, phase="step"):
    """Each detector's time over that of the baseline: the geometric mean with its interval, and the
    ratio at each cell in grey."""
    ratios = figures.document["ratios"]
    ax = new_axes(ax, figures.title)
    if ratios is None:
        return no_data(ax, "no detectors are compared in this file")
    axis = figures.document["detector_axis"]
    means = ratios["means"][phase]
    column = ratios["phases"][phase]
    for i, mean in enumerate(means):
        cells = [column["value"][p] for p, at in enumerate(figures.points["at"])
                 if at[axis] == i and column["is_matched"][p]]
        ax.plot(numbers(cells), np.full(len(cells), i), "|", color="#999999", markersize=12)
        if mean["value"] is None:
            continue
        sides = [[abs(mean["value"] - (mean["low"] if mean["low"] is not None else mean["value"]))],
                 [abs((mean["high"] if mean["high"] is not None else mean["value"]) - mean["value"])]]
        ax.errorbar(mean["value"], i, xerr=sides, fmt="o", color=COLOURS[i % len(COLOURS)], capsize=4)
    ax.axvline(1, color="#000000", linewidth=0.8, linestyle=":")
    ax.set_yticks(range(len(means)), [mean["detector"] for mean in means])
    ax.invert_yaxis()
    log_scale(ax.xaxis)
    ax.set_xlabel(f"time of {phase} over that of {ratios['baseline']} (less is faster)")
    foot(ax, f"Geometric mean over {ratios['matched']} of {ratios['cells']} cells, which are the grey "
             f"lines. {figures.interval_words()}")
    return ax


def plot_errors(figures, error, ax=None, scene=0):
    """Error against run time: the most useful configurations are at the lower right. The front is
    joined; `scene` chooses among scenes, where the file has several."""
    fronts = [front for front in figures.document["fronts"] if front["error"] == error]
    if not fronts:
        names = sorted({front["error"] for front in figures.document["fronts"]})
        raise KeyError(f"there is no error {error!r} in this file; there are {', '.join(names) or 'none'}")
    front = fronts[scene]
    ax = new_axes(ax, figures.title + (f"\n{place_text(front['each'])}" if front["each"] else ""))
    rows = [row for row in front["rows"] if (row["error"] or 0) > 0 and row["ms_per_s"]]
    if not rows:
        return no_data(ax, "no configuration has an error and a time")
    for row in rows:
        x, y = 1000 / row["ms_per_s"], row["error"]
        xerr = [[x - 1000 / row["high"]], [1000 / row["low"] - x]] if row["low"] else None
        yerr = [[y - row["error_low"]], [row["error_high"] - y]] if row["error_low"] else None
        ax.errorbar(x, y, np.abs(yerr) if yerr else None, np.abs(xerr) if xerr else None, fmt="o",
                    capsize=3, color=COLOURS[0] if row["on_front"] else "#999999",
                    mfc="none" if row["is_void"] else None)
        if row["on_front"]:
            ax.annotate(place_text(row["at"]), (x, y), (-5, 5), textcoords="offset points",
                        fontsize="x-small", color="#555555", ha="right")
    best = sorted((1000 / row["ms_per_s"], row["error"]) for row in rows if row["on_front"])
    ax.plot(*zip(*best), color=COLOURS[0], linewidth=1, zorder=0)
    log_scale(ax.xaxis)
    ax.set(yscale="log", xlabel="speed, times real time",
           ylabel=error + (f", {front['unit']}" if front["unit"] else ""))
    ax.margins(x=0.25, y=0.15)
    ax.annotate("better: fast and accurate", (0.98, 0.03), xycoords="axes fraction", ha="right",
                color="#555555", fontsize="small")
    foot(ax, f"Blue: on the front. {figures.interval_words()}")
    return ax


def plot_stability(figures, x, y, ax=None, **place):
    """The verdict over two axes, with the first bad cycle in each cell: plot_stability(figures,
    "speed", "detector"). Other axes are at their first value, or as `place` says."""
    for axis in (x, y):
        figures.find(**{axis: figures.axes[axis]["values"][0]} if axis in figures.axes else {axis: None})
    fixed = {name: place.get(name, values["values"][0]) for name, values in figures.axes.items()
             if name not in (x, y)}
    ax = new_axes(ax, figures.title + (f"\n{place_text(fixed)}" if fixed else ""))
    names = sorted(set(figures.points["verdict"]), key=lambda name: (name != "stable", name))
    columns, rows = (figures.axes[axis]["values"] for axis in (x, y))
    places = figures.places()
    for p in figures.find(**fixed):
        i, j = columns.index(places[p][x]), rows.index(places[p][y])
        verdict, cycle = figures.points["verdict"][p], figures.points["first_bad_cycle"][p]
        colour = VERDICT_COLOURS[names.index(verdict) % len(VERDICT_COLOURS)]
        ax.add_patch(plt.Rectangle((i - 0.48, j - 0.48), 0.96, 0.96, color=colour))
        is_dark = colour in ("#000000", "#0072B2", "#D55E00")
        ax.text(i, j, verdict + ("" if cycle is None else f"\ncycle {cycle}"), ha="center",
                va="center", fontsize="x-small", color="white" if is_dark else "black")
    ax.set(xlim=(-0.5, len(columns) - 0.5), ylim=(-0.5, len(rows) - 0.5), xlabel=figures.label(x),
           ylabel=figures.label(y))
    for values, set_ticks in ((columns, ax.set_xticks), (rows, ax.set_yticks)):
        set_ticks(range(len(values)),
                  [f"{v:g}" if isinstance(v, (int, float)) else v for v in values])
    foot(ax, "The worst verdict of the repeats, and the first cycle at which it applies.")
    return ax
