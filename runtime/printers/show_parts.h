// The sections of a summary (show.h). All throw StoreError.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/figures/model.h"
#include "runtime/printers/document.h"

namespace cdb::printers {

/// The runs, and how far their figures can be trusted.
Section SummaryHead(const figures::Model& model);

/// Detectors that missed pairs, and those that are known to miss some and were not checked.
std::vector<std::string> WrongDetectors(const figures::Model& model);

/// Up to three tables with a row for each value on the axes `by`: the time of every phase, or of
/// those in `phases` if that is not empty, and the means of pairs and contacts; the 5th and 95th
/// percentile over the cycles; and the intervals of the means. None for a file without timings and
/// pairs.
void AddPhases(const figures::Model& model, const std::vector<std::size_t>& by,
               const std::vector<protocol::Phase>& phases, Document& document);

/// Two tables, if the file compares detectors. For detect: mean and worst cycle, pairs, faults and
/// memory of each detector, in the order of their axis, at each point of the other axes, or of `by`
/// if that is not empty; axes that make no rows are pooled. If one axis with at least three numbers
/// changes the number of objects: p of detect ~ objects^p, by least squares over the logarithms of
/// means. Last, other faults of detectors than missed pairs.
void AddDetectors(const figures::Model& model, const std::vector<std::size_t>& by,
                  Document& document);
void AddOtherFaults(const figures::Model& model, Document& document);

/// Times of `phases` (detect and step if that is empty) over those of the baseline (by default the
/// first detector that has all cells), at each point of the other axes, with the interval of each
/// ratio, paired by repeat. The geometric mean is over the points that all detectors have, sound
/// and with the same omissions; ratios of other points are in parentheses.
void AddRatios(const figures::Model& model, const std::string& baseline,
               const std::vector<protocol::Phase>& phases, Document& document);

/// The phases (only the step if `phases` is empty) over the cycles, a line for each of at most 24
/// points; and over each axis of at least three numbers. None for a file without timings.
void AddPlots(const figures::Model& model, const std::vector<protocol::Phase>& phases,
              Document& document);

/// Bars from the least to the greatest of `values`, which are averaged in at most `width` bins; a
/// space for a bin without values. Values within a fraction `alike` of the least are drawn at one
/// height.
std::string Sparkline(const std::vector<double>& values, std::size_t width, double alike = 0);

/// A table with a row for each of `rows`: their axes, the number of pooled cells if some row pools
/// several, figures, and the mark.
class RowTable {
 public:
  RowTable(const results::ResultFile& file, const figures::Rows& rows);
  /// A column of figures.
  void AddColumn(std::string_view head) { table_.AddColumn(head, true); }
  /// A figure for each column. `note` precedes the row's mark.
  void AddRow(const figures::Row& row, const std::vector<std::string>& figures,
              const std::string& note = "");
  Table Take();

 private:
  const results::ResultFile& file_;
  const figures::Rows& rows_;
  Table table_;
  bool has_notes_ = false;
};

/// Adds a column for each of the axes, which identify the rows.
void AddAxes(const results::ResultFile& file, const std::vector<std::size_t>& axes, Table& table);
/// The first columns of a row: its coordinates.
std::vector<std::string> Coordinates(const results::ResultFile& file,
                                     const std::vector<std::size_t>& axes,
                                     const figures::Point& at);

}  // namespace cdb::printers
