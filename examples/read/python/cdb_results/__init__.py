"""Results files of cdb in a notebook.

    import cdb_results as cdb
    results = cdb.open("first.h5")        # the numbers, as xarray datasets
    figures = cdb.figures("first.h5")     # what `cdb show --json` computes: statistics with intervals
    cdb.plot_phases(figures)              # one figure in one line; it returns the axes of matplotlib

Statistics are those of cdb (`cdb doc statistics`); nothing is computed here.
"""
from .figures import Figures, figures
from .plots import plot_errors, plot_over, plot_phases, plot_ratios, plot_stability
from .results import Results, open

__all__ = ["Figures", "Results", "figures", "open", "plot_errors", "plot_over", "plot_phases",
           "plot_ratios", "plot_stability"]
