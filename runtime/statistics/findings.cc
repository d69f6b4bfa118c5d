#include "runtime/statistics/findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "compiler/schema/catalogue.h"
#include "runtime/statistics/numbers.h"

namespace cdb::statistics {
namespace {

bool MayMissPairs(const std::string& detector) {
  const schema::DetectorInfo* info = schema::FindDetector(detector);
  return info != nullptr && info->Makes(schema::KnownErrors::kMissesPairs);
}

/// An incremental mean.
struct RunningMean {
  double sum = 0, count = 0;
  void Add(double value) {
    if (std::isnan(value)) return;
    sum += value;
    ++count;
  }
  double value() const { return count > 0 ? sum / count : kNone; }
};

struct Tally {
  DetectorFindings findings;
  RunningMean depth, normal;
};

/// Cycles without a value are -1.
void AddPairs(const store::ResultFile& file, const store::ResultFile::Cell& cell, Tally& tally) {
  DetectorFindings& findings = tally.findings;
  // A trace has no contacts.
  const auto series = [&](const char* name) {
    return file.Has(name) ? file.ReadSeries(name, cell) : std::vector<double>();
  };
  const auto exact = series("exact_pairs"), missed = series("missed_pairs"),
             false_positives = series("phantom_pairs"), duplicate = series("duplicate_pairs"),
             contacts = series("missed_contacts");
  bool is_wrong = false, is_watched = false;
  for (std::uint64_t cycle = 0; cycle < exact.size(); ++cycle) {
    if (!(exact[cycle] >= 0)) continue;
    is_watched = true;
    ++findings.cycles;
    const auto add = [&](std::uint64_t& sum, const std::vector<double>& values) {
      sum += static_cast<std::uint64_t>(values[cycle]);
      return values[cycle] > 0;
    };
    add(findings.exact, exact);
    add(findings.false_positives, false_positives);
    const auto note = [&](std::uint64_t& sum, const std::vector<double>& values,
                          std::optional<DetectorFindings::Place>& first) {
      if (add(sum, values) && !first) first = {cell, cycle};
    };
    note(findings.missed, missed, findings.first_missed);
    note(findings.duplicate, duplicate, findings.first_duplicate);
    if (cycle < contacts.size() && contacts[cycle] >= 0)
      note(findings.missed_contacts, contacts, findings.first_missed_contact);
    is_wrong = is_wrong || missed[cycle] > 0;
  }
  for (const double error : series("depth_error")) tally.depth.Add(error);
  for (const double error : series("normal_error")) tally.normal.Add(error);
  findings.wrong_runs += is_wrong ? 1 : 0;
  ++(is_watched ? findings.runs : findings.unwatched_runs);
}

}  // namespace

std::vector<DetectorFindings> FindingsOf(const store::ResultFile& file) {
  const bool has_pairs = file.Has("exact_pairs");
  const CellDetectors detectors(file);
  std::vector<Tally> tallies;
  const auto tally_of = [&](const std::string& detector) -> Tally& {
    const auto found = std::ranges::find(
        tallies, detector, [](const Tally& tally) { return tally.findings.detector; });
    if (found != tallies.end()) return *found;
    Tally& tally = tallies.emplace_back();
    tally.findings.detector = detector;
    return tally;
  };
  if (const auto axis = DetectorAxis(file))
    for (const auto& value : file.axes()[*axis].values) tally_of(std::get<std::string>(value));
  std::set<std::string> seen;
  for (const store::ResultFile::Cell& cell : AllCells(file)) {
    const store::Status status = file.ReadStatus(cell);
    if (status == store::Status::kSkipped || status == store::Status::kMissing) continue;
    if (!seen.insert(file.ReadText("run_id", cell)).second) continue;
    Tally& tally = tally_of(detectors.Of(cell));
    if (status != store::Status::kDone) {
      ++tally.findings.failed_runs;
      if (!tally.findings.first_failed) tally.findings.first_failed = cell;
    }
    if (has_pairs) {
      AddPairs(file, cell, tally);
    } else {
      ++tally.findings.unwatched_runs;
    }
  }
  std::vector<DetectorFindings> all;
  for (Tally& tally : tallies) {
    tally.findings.depth_error = tally.depth.value();
    tally.findings.normal_error = tally.normal.value();
    all.push_back(std::move(tally.findings));
  }
  return all;
}

std::string WrongDetectors(const store::ResultFile& file,
                           const std::vector<DetectorFindings>& findings) {
  std::string text;
  for (const DetectorFindings& of : findings) {
    if (of.missed == 0) continue;
    text += fmt::format(
        "  WRONG: {} missed {} of {} pairs, in {} of {} {}; first in cycle {} of {}.\n    Its "
        "times are of less work than necessary. To repeat that run: {}\n",
        of.detector, of.missed, of.exact, of.wrong_runs, of.runs, of.runs == 1 ? "run" : "runs",
        of.first_missed->cycle, PlaceText(file, of.first_missed->cell),
        OnlyCommand(file, of.first_missed->cell));
  }
  std::string names;
  for (const DetectorFindings& of : findings)
    if (of.missed == 0 && of.unwatched_runs > 0 && MayMissPairs(of.detector))
      names += (names.empty() ? "" : ", ") + of.detector;
  if (!names.empty())
    text += fmt::format("  Known to miss pairs, but not checked: {}. `record pairs` checks them.\n",
                        names);
  return text;
}

std::string OtherFaults(const std::vector<DetectorFindings>& findings) {
  const auto line = [&](const char* head, std::uint64_t DetectorFindings::*count, bool of_exact) {
    std::string text;
    for (const DetectorFindings& of : findings)
      if (of.*count > 0)
        text += fmt::format("{}{} {}{}", text.empty() ? "" : ", ", of.detector, of.*count,
                            of_exact ? fmt::format(" beside {}", of.exact) : "");
    return text.empty() ? text : fmt::format("\n{}: {}.\n", head, text);
  };
  return line("Pairs listed that do not overlap", &DetectorFindings::false_positives, true) +
         line("Pairs listed again", &DetectorFindings::duplicate, true) +
         line("Overlaps without a contact", &DetectorFindings::missed_contacts, false);
}

}  // namespace cdb::statistics
