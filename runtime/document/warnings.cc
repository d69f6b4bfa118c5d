#include "runtime/document/warnings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <utility>

#include "runtime/report/show_noise.h"
#include "runtime/statistics/cells.h"
#include "runtime/statistics/detector_ratios.h"
#include "runtime/statistics/processors.h"

namespace cdb::document {
namespace {

class WarningList {
 public:
  explicit WarningList(const DocumentSource& source)
      : source_(source), file_(source.file()), groups_(source.groups()) {}

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
    if (source_.IsLarge())
      Add("pooled", fmt::format("There are {} points: the page has only the mean of step and "
                                "detect of each, without single cycles.",
                                source_.points().size()));
    return std::move(all_);
  }

 private:
  void Add(const char* kind, std::string text) {
    all_.push_back({{"kind", kind}, {"text", std::move(text)}});
  }

  void AddBuild() {
    if (const std::string build = file_.ReadProvenance("build_type"); build != "Release")
      Add("debug", fmt::format("Timed with a {} build of cdb: do not quote these timings.", build));
  }

  void AddFindings() {
    for (const statistics::DetectorFindings& of : source_.findings())
      if (of.missed > 0)
        Add("missed_pairs", fmt::format("{} missed {} of {} pairs, in {} of {} {}: its times are "
                                        "of less work than necessary.",
                                        of.detector, of.missed, of.exact, of.wrong_runs, of.runs,
                                        of.runs == 1 ? "run" : "runs"));
  }

  void AddBadRuns() {
    std::map<std::string, std::size_t> faults;
    for (const statistics::CellGroups::Bad& bad : groups_.bad)
      ++faults[statistics::FaultOf(file_, bad.cell)];
    std::vector<std::string> texts;
    for (const auto& [fault, count] : faults) texts.push_back(fmt::format("{} {}", count, fault));
    if (!texts.empty())
      Add("failed", fmt::format("{} of {} runs did not end well ({}); they are marked, and not "
                                "pooled with others in means and ratios.",
                                groups_.bad.size(), groups_.NotSkipped(), fmt::join(texts, ", ")));
    for (const std::string& trouble : source_.references())
      Add("failed", fmt::format("A reference is missing: {}", trouble));
  }

  void AddVerdicts() {
    std::vector<std::string> texts;
    for (auto row = groups_.verdicts.rbegin(); row != groups_.verdicts.rend(); ++row)
      if (row->first > measure::Verdict::kStable)
        texts.push_back(fmt::format("{} {}", row->second.size(), measure::VerdictName(row->first)));
    if (!texts.empty())
      Add("unsound", fmt::format("The simulation was not sound in some runs ({}); their times are "
                                 "in the figures.",
                                 fmt::join(texts, ", ")));
  }

  void AddNoise() {
    if (const std::string jobs = file_.ReadProvenance("jobs"); !jobs.empty() && jobs != "1")
      Add("noise",
          fmt::format("Timed with parallel runs (jobs {}), which disturb each other.", jobs));
    if (const std::string noise = Sentence(report::NoiseText(file_, groups_.good)); !noise.empty())
      Add("noise", noise);
  }

  void AddProcessors() {
    const std::string text = statistics::ProcessorText(file_, groups_.good);
    if (text.empty()) return;
    std::vector<std::string> lines;
    std::istringstream all(text);
    for (std::string line; std::getline(all, line);) lines.push_back(Sentence(line));
    Add("processors", fmt::format("{}", fmt::join(lines, " ")));
  }

  /// The compared detectors had different omissions.
  void AddUnlike() {
    std::set<std::string> components;
    for (const statistics::MeasuredPoint& point : source_.measured())
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
    if (!source_.HasTimes()) return;
    if (file_.begun_repeats() == 1) {
      Add("repeats", "One repeat: there are no intervals.");
    } else if (file_.begun_repeats() < statistics::Bootstrap::kLeastForInterval) {
      Add("repeats", fmt::format("{} repeats: ranges instead of intervals, which need {}.",
                                 file_.begun_repeats(), statistics::Bootstrap::kLeastForInterval));
    }
  }

  const DocumentSource& source_;
  const store::ResultFile& file_;
  const statistics::CellGroups& groups_;
  Json all_ = Json::array();
};

}  // namespace

Json DocumentWarnings(const DocumentSource& source) { return WarningList(source).All(); }

}  // namespace cdb::document
