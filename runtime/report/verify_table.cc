#include "runtime/report/verify_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "runtime/statistics/findings.h"
#include "runtime/terminal/table.h"

namespace cdb::report {
namespace {

/// The fault of a detector or a narrow phase, the worst first.
enum class Fault { kMisses, kFails, kNone };

/// A detector or a narrow phase.
struct Phase {
  statistics::DetectorFindings of;
  bool is_narrow;

  Fault FaultOf() const {
    if ((is_narrow ? of.missed_contacts : of.missed) > 0) return Fault::kMisses;
    return !is_narrow && of.failed_runs > 0 ? Fault::kFails : Fault::kNone;
  }
  /// Makes the contacts of detectors without a narrow phase, which are not at fault.
  bool IsBullet() const { return is_narrow && of.detector == "bullet"; }

  std::string Verdict() const {
    switch (FaultOf()) {
      case Fault::kMisses:
        return is_narrow ? "wrong: misses contacts" : "wrong: misses pairs";
      case Fault::kFails:
        return fmt::format("failed: {} of {}", of.failed_runs, of.AllRuns());
      case Fault::kNone:
        break;
    }
    if (is_narrow) return of.exact_contacts > 0 ? "misses none" : "nothing to judge";
    if (of.cycles == 0) return "nothing to judge";
    if (of.duplicate > 0) return "lists pairs twice";
    return of.false_positives > 0 ? "superset" : "exact";
  }
};

constexpr const char* kBulletsContacts =
    "  Bullet makes the contacts of detectors without a narrow phase: these are not their fault.\n";

std::string ErrorText(double value) {
  return std::isnan(value) ? "-" : fmt::format("{:.1e}", value);
}

class Verified {
 public:
  Verified(const store::ResultFile& file, const std::map<std::string, std::string>& narrow_phases)
      : file_(file) {
    const auto add = [&](const std::vector<statistics::DetectorFindings>& all, bool is_narrow) {
      std::vector<Phase> phases;
      for (const statistics::DetectorFindings& of : all)
        if (of.AllRuns() > 0) phases.push_back({of, is_narrow});
      std::ranges::stable_sort(phases, {}, &Phase::FaultOf);
      all_.insert(all_.end(), phases.begin(), phases.end());
    };
    add(statistics::FindingsOf(file), false);
    add(statistics::FindingsBy(file,
                               [&](const store::ResultFile::Cell& cell) {
                                 const auto found =
                                     narrow_phases.find(file.ReadText("run_id", cell));
                                 return found == narrow_phases.end() ? "unknown" : found->second;
                               }),
        true);
  }

  bool IsGood() const {
    return std::ranges::all_of(all_, [](const Phase& phase) {
      return phase.FaultOf() == Fault::kNone || phase.IsBullet();
    });
  }

  std::string Text() const {
    terminal::Table table;
    table.AddColumn("detector", false);
    for (const char* head : {"points", "cycles", "exact pairs", "missed", "phantom", "duplicate",
                             "contacts compared", "missed", "depth error", "normal error"})
      table.AddColumn(head, true);
    table.AddColumn("verdict", false);
    std::string below;
    for (const Phase& phase : all_) {
      const statistics::DetectorFindings& of = phase.of;
      std::vector<std::string> row = {phase.is_narrow ? "contacts by " + of.detector : of.detector,
                                      fmt::format("{}", of.AllRuns()),
                                      fmt::format("{}", of.cycles)};
      for (const std::uint64_t count : {of.exact, of.missed, of.false_positives, of.duplicate})
        row.push_back(phase.is_narrow ? "-" : fmt::format("{}", count));
      const auto add = [&](const std::string& text) {
        row.push_back(phase.is_narrow ? text : "-");
      };
      add(fmt::format("{} of {}", of.exact_contacts, of.exact_contacts + of.unsure_contacts));
      add(fmt::format("{}", of.missed_contacts));
      for (const double error : {of.depth_error, of.normal_error}) add(ErrorText(error));
      row.push_back(phase.Verdict());
      table.AddRow(std::move(row));
      below += Below(phase);
    }
    return table.Text() + (below.empty() ? "" : "\n" + below);
  }

 private:
  /// The first occurrence of each fault, and the command that reproduces it.
  std::string Below(const Phase& phase) const {
    const statistics::DetectorFindings& of = phase.of;
    std::string text;
    const auto add = [&](const std::string& what, const store::ResultFile::Cell& cell) {
      text +=
          fmt::format("  {} {}\n    {}\n", of.detector, what, statistics::OnlyCommand(file_, cell));
    };
    const auto from = [&](const char* what,
                          const std::optional<statistics::DetectorFindings::Place>& first) {
      if (first)
        add(fmt::format("{} from cycle {} of {} on", what, first->cycle,
                        statistics::PlaceText(file_, first->cell)),
            first->cell);
    };
    if (phase.is_narrow) {
      from("misses contacts", of.first_missed_contact);
      if (phase.IsBullet() && phase.FaultOf() == Fault::kMisses) text += kBulletsContacts;
      return text;
    }
    from("misses pairs", of.first_missed);
    from("lists pairs twice", of.first_duplicate);
    if (of.first_failed)
      add(fmt::format("{} at {}: {}", store::StatusName(file_.ReadStatus(*of.first_failed)),
                      statistics::PlaceText(file_, *of.first_failed),
                      file_.ReadText("message", *of.first_failed)),
          *of.first_failed);
    return text;
  }

  const store::ResultFile& file_;
  std::vector<Phase> all_;  ///< detectors, then narrow phases
};

}  // namespace

VerifyText VerifyTable(const store::ResultFile& file,
                       const std::map<std::string, std::string>& narrow_phases,
                       const std::vector<std::string>& left_out) {
  const Verified verified(file, narrow_phases);
  std::string text = fmt::format("{}\n{}", file.title(), verified.Text());
  for (const std::string& line : left_out) text += fmt::format("  Left out: {}.\n", line);
  return {text, verified.IsGood()};
}

}  // namespace cdb::report
