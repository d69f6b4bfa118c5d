// Warnings to read before quoting a figure, for results documents.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "runtime/printers/json_parts.h"
#include "runtime/printers/notes.h"

namespace cdb::printers {
namespace {

class WarningList {
 public:
  explicit WarningList(const figures::Model& model)
      : model_(model), file_(model.file()), groups_(model.runs()) {}

  Json All() {
    AddBuild();
    AddFindings();
    AddBadRuns();
    AddVerdicts();
    AddNoise();
    AddProcessors();
    AddUnlike();
    AddMissing();
    AddRepeats();
    if (IsLarge(model_))
      Add("pooled", fmt::format("There are {} points: the page has only the mean of step and "
                                "detect of each, without single cycles.",
                                model_.grid().size()));
    return std::move(all_);
  }

 private:
  void Add(const char* kind, std::string text) {
    all_.push_back({{"kind", kind}, {"text", std::move(text)}});
  }

  void AddBuild() {
    if (const std::string note = BuildNote(file_); !note.empty()) Add("debug", note);
  }

  void AddFindings() {
    for (const figures::DetectorFindings& of : model_.findings())
      if (of.missed > 0)
        Add("missed_pairs", fmt::format("{} missed {} of {} pairs, in {} of {} {}: its times are "
                                        "of less work than necessary.",
                                        of.detector, of.missed, of.exact, of.wrong_runs, of.runs,
                                        of.runs == 1 ? "run" : "runs"));
  }

  void AddBadRuns() {
    std::map<std::string, std::size_t> faults;
    for (const figures::CellGroups::Bad& bad : groups_.bad)
      ++faults[figures::EndingOf(file_, bad.cell).Word()];
    std::vector<std::string> texts;
    for (const auto& [fault, count] : faults) texts.push_back(fmt::format("{} {}", count, fault));
    if (!texts.empty())
      Add("failed", fmt::format("{} of {} runs did not end well ({}); they are marked, and not "
                                "pooled with others in means and ratios.",
                                groups_.bad.size(), groups_.NotSkipped(), fmt::join(texts, ", ")));
    for (const std::string& trouble : model_.reference_troubles())
      Add("failed", fmt::format("A reference is missing: {}", trouble));
  }

  void AddVerdicts() {
    std::vector<std::string> texts;
    for (auto row = groups_.verdicts.rbegin(); row != groups_.verdicts.rend(); ++row)
      if (row->first > protocol::Verdict::kStable)
        texts.push_back(
            fmt::format("{} {}", row->second.size(), protocol::VerdictName(row->first)));
    if (!texts.empty())
      Add("unsound",
          fmt::format(
              "The simulation was not sound in some runs ({}); their times are in the figures.",
              fmt::join(texts, ", ")));
  }

  void AddNoise() {
    for (const std::string& note : {JobsNote(file_), NoiseNote(file_, groups_.good)})
      if (!note.empty()) Add("noise", note);
  }

  void AddProcessors() {
    const std::vector<std::string> notes = ProcessorNotes(file_, groups_.good);
    std::string text;
    for (const std::string& note : notes)
      text += (text.empty() ? "" : " ") + note.substr(note.find_first_not_of(' '));
    if (!text.empty()) Add("processors", text);
  }

  /// The compared detectors had different omissions.
  void AddUnlike() {
    std::set<std::string> components;
    for (const figures::MeasuredPoint& point : model_.points())
      components.insert(point.unlike.begin(), point.unlike.end());
    if (!components.empty())
      Add("unlike", fmt::format("Some points ran without {} and others with it; they are marked.",
                                fmt::join(components, ", ")));
  }

  void AddMissing() {
    if (groups_.missing > 0)
      Add("partial",
          fmt::format("{} of {} runs are missing.", groups_.missing, groups_.NotSkipped()));
  }

  void AddRepeats() {
    if (!model_.HasTimes()) return;
    if (file_.begun_repeats() == 1) {
      Add("repeats", "One repeat: there are no intervals.");
    } else if (file_.begun_repeats() < figures::Bootstrap::kLeastForInterval) {
      Add("repeats", fmt::format("{} repeats: ranges instead of intervals, which need {}.",
                                 file_.begun_repeats(), figures::Bootstrap::kLeastForInterval));
    }
  }

  const figures::Model& model_;
  const results::ResultFile& file_;
  const figures::CellGroups& groups_;
  Json all_ = Json::array();
};

}  // namespace

Json DocumentWarnings(const figures::Model& model) { return WarningList(model).All(); }

}  // namespace cdb::printers
