#include "runtime/cli/verify_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "runtime/cli/findings.h"
#include "runtime/cli/table.h"

namespace cdb::runtime {
namespace {

/// The worse, the smaller.
int Rank(const DetectorFindings& of) { return of.missed > 0 ? 0 : of.failed_runs > 0 ? 1 : 2; }

std::string Verdict(const DetectorFindings& of) {
  if (of.missed > 0) return "wrong: misses pairs";
  if (of.failed_runs > 0) return fmt::format("failed: {} of {}", of.failed_runs, of.AllRuns());
  if (of.cycles == 0) return "nothing to judge";
  if (of.duplicate > 0) return "lists pairs twice";
  return of.phantom > 0 ? "superset" : "exact";
}

std::string ErrorText(double value) {
  return std::isnan(value) ? "-" : fmt::format("{:.1e}", value);
}

class Verified {
 public:
  Verified(const ResultFile& file) : file_(file), all_(FindingsOf(file)) {
    std::erase_if(all_, [](const DetectorFindings& of) { return of.AllRuns() == 0; });
    std::ranges::stable_sort(all_, {}, Rank);
  }

  bool IsGood() const {
    return std::ranges::all_of(all_, [](const auto& of) { return Rank(of) == 2; });
  }

  std::string Text() const {
    Table table;
    table.AddColumn("detector", false);
    for (const char* head : {"points", "cycles", "exact pairs", "missed", "phantom", "duplicate",
                             "contacts missed", "depth error", "normal error"})
      table.AddColumn(head, true);
    table.AddColumn("verdict", false);
    std::string below;
    for (const DetectorFindings& of : all_) {
      std::vector<std::string> row = {of.detector};
      for (const std::uint64_t count : {std::uint64_t{of.AllRuns()}, of.cycles, of.exact, of.missed,
                                        of.phantom, of.duplicate, of.missed_contacts})
        row.push_back(fmt::format("{}", count));
      for (const double error : {of.depth_error, of.normal_error}) row.push_back(ErrorText(error));
      row.push_back(Verdict(of));
      table.AddRow(std::move(row));
      below += Below(of);
    }
    return table.Text() + (below.empty() ? "" : "\n" + below);
  }

 private:
  /// Where it goes wrong, and how to see that.
  std::string Below(const DetectorFindings& of) const {
    const auto at = [&](const char* what, const ResultFile::Cell& cell, const std::string& when) {
      return fmt::format("  {} {}{}: {}\n    cdb run {} --only {}\n", of.detector, what, when,
                         PlaceText(file_, cell), file_.source(), file_.ReadText("run_id", cell));
    };
    const auto from = [](const DetectorFindings::Place& place) {
      return fmt::format(" from cycle {} on", place.cycle);
    };
    std::string text;
    if (of.first_missed) text += at("misses pairs", of.first_missed->cell, from(*of.first_missed));
    if (of.first_duplicate)
      text += at("lists pairs twice", of.first_duplicate->cell, from(*of.first_duplicate));
    if (of.first_failed)
      text += at(std::string(StatusName(file_.ReadStatus(*of.first_failed))).c_str(),
                 *of.first_failed, " (" + file_.ReadText("message", *of.first_failed) + ")");
    return text;
  }

  const ResultFile& file_;
  std::vector<DetectorFindings> all_;
};

}  // namespace

VerifyText VerifyTable(const ResultFile& file, const std::vector<std::string>& left_out) {
  const Verified verified(file);
  std::string text = fmt::format("{}\n{}", file.title(), verified.Text());
  for (const std::string& line : left_out) text += fmt::format("  Left out: {}.\n", line);
  return {text, verified.IsGood()};
}

}  // namespace cdb::runtime
