// Narrow phases on the pairs of a trace, for `cdb show`.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "runtime/printers/show.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

using figures::Row;

constexpr const char* kUnhandled = "unhandled_pairs";
constexpr const char* kExact = "exact_contacts";

class PairTable {
 public:
  PairTable(const figures::Model& model, const std::vector<std::size_t>& by)
      : model_(model), rows_(figures::MatchRows(model.points(), by)) {
    is_judged_ = model.file().Has(kExact);
  }

  void AddTo(Document& document) {
    RowTable table(model_.file(), rows_);
    for (const char* head : {"pairs", "unhandled", "ns/pair"})
      if (head != std::string_view("ns/pair") || model_.HasTimes()) table.AddColumn(head);
    if (is_judged_)
      for (const char* head :
           {"compared", "missed", "false", "depth error", "largest", "normal error", "largest"})
        table.AddColumn(head);
    for (const Row& row : rows_.rows) {
      const double pairs = Sum(row, "pairs"), unhandled = Sum(row, kUnhandled);
      if (std::isnan(unhandled)) continue;  // it ran a broad phase
      leaves_pairs_ = leaves_pairs_ || unhandled > 0;
      differs_ = differs_ || (!std::isnan(handled_) && handled_ != pairs - unhandled);
      handled_ = pairs - unhandled;
      std::vector<std::string> figures = {CountText(pairs), CountText(unhandled)};
      if (model_.HasTimes()) {
        const double cycles = Cycles(row);
        figures.push_back(terminal::ShortNumber(
            pairs > unhandled
                ? model_.TimeOf(row, protocol::Phase::kNarrow).value * cycles / (pairs - unhandled)
                : figures::kNone));
      }
      if (is_judged_) AddJudgement(row, figures);
      table.AddRow(row, figures, figures::UnsoundText(model_.file(), row));
    }
    Section section = {.title = "Narrow phases on the pairs of a trace, sums over the cycles",
                       .table = table.Take()};
    section.notes.push_back(
        "ns/pair: narrow over the pairs that it handles. Bullet's time includes keeping its "
        "manifolds (cdb doc traces).");
    if (leaves_pairs_)
      section.notes.push_back(
          "unhandled: pairs that the narrow phase leaves to Bullet; they are not in its time.");
    if (differs_)
      section.notes.push_back(
          "ns/pair is over different pairs, as the narrow phases leave different ones to Bullet. "
          "With "
          "world.wall_shape box, or without walls, they leave fewer.");
    if (is_judged_)
      section.notes.push_back(
          "compared: overlaps with an exact answer, of all that may overlap; errors of depth in "
          "sizes of the smaller object, of normals in rad.");
    document.push_back(std::move(section));
  }

 private:
  static std::string CountText(double count) { return fmt::format("{:.0f}", count); }

  /// Calls `visit` with the values of each cycle of the row.
  template <typename Visit>
  void ForValues(const Row& row, const char* series, Visit visit) const {
    if (!model_.file().Has(series)) return;
    for (const figures::MeasuredPoint* point : row.points)
      for (const double value : model_.file().ReadSeries(series, point->cells[0]))
        if (value >= 0) visit(value);
  }
  /// NaN if there is no value.
  double Sum(const Row& row, const char* series) const {
    double sum = figures::kNone;
    ForValues(row, series, [&](double value) { sum = std::isnan(sum) ? value : sum + value; });
    return sum;
  }
  double Cycles(const Row& row) const {
    double cycles = 0;
    ForValues(row, kUnhandled, [&](double) { ++cycles; });
    return cycles;
  }
  double Mean(const Row& row, const char* series) const {
    double sum = 0, count = 0;
    ForValues(row, series, [&](double value) {
      sum += value;
      ++count;
    });
    return count > 0 ? sum / count : figures::kNone;
  }
  double Largest(const Row& row, const char* series) const {
    double largest = figures::kNone;
    ForValues(row, series, [&](double value) { largest = std::fmax(largest, value); });
    return largest;
  }

  void AddJudgement(const Row& row, std::vector<std::string>& figures) const {
    const double exact = Sum(row, kExact);
    figures.push_back(
        fmt::format("{:.0f} of {:.0f}", exact, exact + Sum(row, "uncompared_contacts")));
    figures.push_back(CountText(Sum(row, "missed_contacts")));
    figures.push_back(CountText(Sum(row, "false_contacts")));
    for (const char* error : {"depth_error", "normal_error"}) {
      figures.push_back(terminal::ShortNumber(Mean(row, error)));
      figures.push_back(terminal::ShortNumber(Largest(row, fmt::format("max_{}", error).c_str())));
    }
  }

  const figures::Model& model_;
  const figures::Rows rows_;
  bool is_judged_ = false, leaves_pairs_ = false, differs_ = false;
  double handled_ = figures::kNone;  ///< pairs, in the last row
};

}  // namespace

void AddPairs(const figures::Model& model, const std::vector<std::size_t>& by, Document& document) {
  if (!model.points().empty() && model.file().Has(kUnhandled)) PairTable(model, by).AddTo(document);
}

}  // namespace cdb::printers
