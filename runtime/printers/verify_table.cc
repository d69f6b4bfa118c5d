#include "runtime/printers/show.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "runtime/figures/model.h"
#include "runtime/printers/document.h"

namespace cdb::printers {
namespace {

/// The fault of a detector, the worst first.
enum class Fault { kMissesPairs, kMissesContacts, kFails, kNone };

Fault FaultOf(const figures::DetectorFindings& of) {
  if (of.missed > 0) return Fault::kMissesPairs;
  if (of.missed_contacts > 0) return Fault::kMissesContacts;
  return of.failed_runs > 0 ? Fault::kFails : Fault::kNone;
}

bool MissesOnlyContacts(const figures::DetectorFindings& of) {
  return FaultOf(of) == Fault::kMissesContacts;
}

/// Boxes of objects in contact overlap.
constexpr const char* kOnlyContacts =
    "If no pair is missed, the narrow phase misses the contacts, not the detector.";

std::string Verdict(const figures::DetectorFindings& of) {
  switch (FaultOf(of)) {
    case Fault::kMissesPairs:
      return "wrong: misses pairs";
    case Fault::kMissesContacts:
      return "wrong: misses contacts";
    case Fault::kFails:
      return fmt::format("failed: {} of {}", of.failed_runs, of.AllRuns());
    case Fault::kNone:
      break;
  }
  if (of.cycles == 0) return "nothing to judge";
  if (of.duplicate > 0) return "lists pairs twice";
  return of.false_positives > 0 ? "superset" : "exact";
}

std::string ErrorText(double value) {
  return std::isnan(value) ? "-" : fmt::format("{:.1e}", value);
}

class Verified {
 public:
  explicit Verified(const results::ResultFile& file)
      : file_(file), all_(figures::FindingsOf(file)) {
    std::erase_if(all_, [](const figures::DetectorFindings& of) { return of.AllRuns() == 0; });
    std::ranges::stable_sort(all_, {}, FaultOf);
  }

  bool IsGood() const {
    return std::ranges::all_of(all_, [](const auto& of) { return FaultOf(of) == Fault::kNone; });
  }

  Document Made(const std::vector<std::string>& left_out) const {
    Section section = {.title = file_.title()}, below;
    Table& table = section.table;
    table.AddColumn("detector", false);
    for (const char* head : {"points", "cycles", "exact pairs", "missed", "phantom", "duplicate",
                             "contacts missed", "depth error", "normal error"})
      table.AddColumn(head, true);
    table.AddColumn("verdict", false);
    for (const figures::DetectorFindings& of : all_) {
      std::vector<std::string> row = {of.detector};
      for (const std::uint64_t count : {std::uint64_t{of.AllRuns()}, of.cycles, of.exact, of.missed,
                                        of.false_positives, of.duplicate, of.missed_contacts})
        row.push_back(fmt::format("{}", count));
      for (const double error : {of.depth_error, of.normal_error}) row.push_back(ErrorText(error));
      row.push_back(Verdict(of));
      table.rows.push_back(std::move(row));
      AddBelow(of, below.lines);
    }
    if (std::ranges::any_of(all_, MissesOnlyContacts)) below.lines.emplace_back(kOnlyContacts);
    std::vector<std::string>& last = below.lines.empty() ? section.notes : below.lines;
    for (const std::string& line : left_out) last.push_back(fmt::format("Omitted: {}.", line));
    return below.lines.empty() ? Document{section} : Document{section, below};
  }

 private:
  /// The first occurrence of each fault, and the command that reproduces it.
  void AddBelow(const figures::DetectorFindings& of, std::vector<std::string>& lines) const {
    const auto add = [&](const std::string& what, const figures::Cell& cell) {
      lines.push_back(fmt::format("{} {}", of.detector, what));
      lines.push_back("  " + figures::OnlyCommand(file_, cell));
    };
    const auto from = [&](const char* what,
                          const std::optional<figures::DetectorFindings::Place>& first) {
      if (first)
        add(fmt::format("{} from cycle {} of {} on", what, first->cycle,
                        figures::PlaceText(file_, first->cell)),
            first->cell);
    };
    from("misses pairs", of.first_missed);
    from("misses contacts", of.first_missed_contact);
    from("lists pairs twice", of.first_duplicate);
    if (of.first_failed)
      add(fmt::format("{} at {}: {}", results::StatusName(file_.ReadStatus(*of.first_failed)),
                      figures::PlaceText(file_, *of.first_failed),
                      file_.ReadText("message", *of.first_failed)),
          *of.first_failed);
  }

  const results::ResultFile& file_;
  std::vector<figures::DetectorFindings> all_;
};

}  // namespace

VerifyText VerifyTable(const results::ResultFile& file, const std::vector<std::string>& left_out) {
  const Verified verified(file);
  return {TextOf(verified.Made(left_out), Format::kTerminal), verified.IsGood()};
}

}  // namespace cdb::printers
