#include "runtime/report/show_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <sstream>

#include "compiler/analysis/pruning.h"
#include "compiler/schema/metrics.h"
#include "compiler/schema/schema.h"
#include "runtime/report/show_noise.h"
#include "runtime/statistics/cells.h"
#include "runtime/statistics/processors.h"

namespace cdb::report {
namespace {

using Cell = store::ResultFile::Cell;

constexpr std::size_t kMaxBadListed = 8;
/// A smaller fraction of the tensor without values is not reported.
constexpr double kNoticeablePadding = 0.05;

class Head {
 public:
  Head(const store::ResultFile& file, const HeadParts& parts)
      : file_(file), parts_(parts), groups_(parts.groups), measured_(groups_.good) {
    if (!measured_.empty()) return;
    for (const statistics::CellGroups::Bad& bad : groups_.bad) measured_.push_back(bad.cell);
  }

  std::string Text() const {
    std::string text = Grid() + NoiseText(file_, measured_) +
                       statistics::ProcessorText(file_, measured_) +
                       statistics::WrongDetectors(file_, parts_.findings) + Timing();
    for (const std::string& trouble : parts_.references)
      text += fmt::format("  A reference is missing: {}\n", trouble);
    text += parts_.harness + LeftOut() + Models() + Verdicts() + Errors();
    return text + Missing() + BadRuns();
  }

 private:
  std::string Missing() const {
    if (groups_.missing == 0) return {};
    const std::uint64_t begun = file_.begun_repeats(), all = file_.repeats();
    const bool are_late = groups_.missing * all == (all - begun) * groups_.NotSkipped();
    return fmt::format(
        "  {} not run yet{}.\n", groups_.missing,
        are_late ? fmt::format(": repeats {} to {} of each point", begun + 1, all) : "");
  }

  /// The title and the number of runs.
  std::string Grid() const {
    std::string grid;
    for (const plan::Axis& axis : file_.axes())
      grid += fmt::format("{}{} {}", grid.empty() ? "" : " x ", axis.values.size(), axis.name);
    if (file_.repeats() > 1)
      grid += fmt::format("{}{} rep", grid.empty() ? "" : " x ", file_.repeats());
    const std::size_t cells = groups_.NotSkipped();
    std::string text =
        fmt::format("{}\n  {} {}{}, {} cycles", file_.title(), cells, cells == 1 ? "run" : "runs",
                    grid.empty() ? "" : " (" + grid + ")", file_.cycles());
    if (groups_.skipped > 0) text += fmt::format(", {} skipped", groups_.skipped);
    return text + '\n' + Padding();
  }

  /// The tensor is as long as the longest run; cycles beyond the end of shorter ones have no
  /// values.
  std::string Padding() const {
    std::uint64_t least = file_.cycles(), all = 0;
    for (const Cell& cell : groups_.good) {
      const std::uint64_t cycles = file_.ReadCycleCount(cell);
      least = std::min(least, cycles);
      all += cycles;
    }
    const double room = static_cast<double>(groups_.good.size() * file_.cycles());
    const double share = room > 0 ? 1 - static_cast<double>(all) / room : 0;
    if (share < kNoticeablePadding) return {};
    return fmt::format(
        "  The runs have {} to {} cycles: {:.0f} % of the arrays over cycles is padding.\n", least,
        file_.cycles(), 100 * share);
  }

  /// The reasons why the timings must not be quoted.
  std::string Timing() const {
    std::string text;
    if (const std::string build = file_.ReadProvenance("build_type"); build != "Release")
      text += fmt::format("  Timed with a {} build of cdb: do not quote these timings.\n", build);
    if (const std::string jobs = file_.ReadProvenance("jobs"); !jobs.empty() && jobs != "1")
      text +=
          fmt::format("  Timed with parallel runs (jobs {}), which disturb each other.\n", jobs);
    return text;
  }

  /// The command that shows the errors, if the file has any.
  std::string Errors() const {
    std::string names;
    for (const schema::ErrorInfo& error : schema::Errors())
      if (file_.Has(fmt::format("accuracy/{}", error.name)))
        names += fmt::format("{}{}", names.empty() ? "" : ", ", error.name);
    return names.empty() ? names : fmt::format("  Errors, by cdb show --error: {}.\n", names);
  }

  /// How sound the physics of the runs in the figures is. Empty if no run was judged.
  std::string Verdicts() const {
    std::string doubts;
    for (auto row = groups_.verdicts.rbegin(); row != groups_.verdicts.rend(); ++row) {
      const auto& [verdict, runs] = *row;
      if (verdict <= measure::Verdict::kStable) continue;
      doubts +=
          fmt::format("    {} {}: {} from cycle {} on{}\n", runs.size(),
                      measure::VerdictName(verdict), statistics::PlaceText(file_, runs[0].cell),
                      runs[0].first_bad_cycle, runs.size() > 1 ? ", and others" : "");
    }
    const auto stable = groups_.verdicts.find(measure::Verdict::kStable);
    const std::size_t sound = stable == groups_.verdicts.end() ? 0 : stable->second.size();
    if (doubts.empty()) {
      if (sound == 0) return "";
      const std::size_t runs = groups_.NotSkipped();
      return sound < runs ? fmt::format("  Verdict: {} of {} stable.\n", sound, runs)
                          : fmt::format("  Verdict: {}stable.\n", sound > 1 ? "all " : "");
    }
    return fmt::format("  {} stable; in the figures below, but not sound (cdb doc verdicts):\n{}",
                       sound, doubts);
  }

  /// How well the convex hulls approximate the models of the scene, a line for each.
  std::string Models() const {
    std::set<std::string> lines;
    std::istringstream all(file_.ReadProvenance("models"));
    for (std::string line; std::getline(all, line);) {
      // The texts of several runs are joined.
      if (line.starts_with("; ")) line.erase(0, 2);
      if (!line.empty()) lines.insert(line);
    }
    std::string text;
    for (const std::string& line : lines) text += fmt::format("  {}\n", line);
    return text;
  }

  /// The omissions, and the number of runs with each.
  std::string LeftOut() const {
    if (!file_.Has("omitted")) return {};
    std::map<std::size_t, std::string, std::greater<>> by_count;
    for (const schema::ComponentInfo& info : schema::Components()) {
      if (!info.IsVisible()) continue;
      const auto count =
          static_cast<std::size_t>(std::ranges::count_if(measured_, [&](const Cell& cell) {
            return schema::ListsWord(file_.ReadText("omitted", cell), info.name);
          }));
      if (count == 0) continue;
      std::string& names = by_count[count];
      names += fmt::format("{}{} ({})", names.empty() ? "" : ", ", info.name, info.changes);
    }
    std::string text;
    for (const auto& [count, names] : by_count) {
      const std::string where = count < measured_.size()
                                    ? fmt::format(" in {} of {} runs", count, measured_.size())
                                : count > 1 ? fmt::format(" in all {} runs", count)
                                            : std::string();
      text += fmt::format("{}  Omitted{}: {}.", text.empty() ? "" : "\n", where, names);
    }
    return text.empty() ? text : text + " omit none times everything.\n";
  }

  /// `40 frozen, 5 failed`.
  std::string Faults() const {
    std::map<std::string, std::size_t> counts;
    for (const statistics::CellGroups::Bad& bad : groups_.bad)
      ++counts[statistics::FaultOf(file_, bad.cell)];
    std::string text;
    for (const auto& [fault, count] : counts)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, fault);
    return text;
  }

  /// Runs that are not pooled with others in any figure.
  std::string BadRuns() const {
    const auto& bad = groups_.bad;
    if (bad.empty()) return {};
    std::string text = fmt::format(
        "  {} did not end well ({}), {}:\n", bad.size(), Faults(),
        parts_.only_sound ? "excluded by --sound"
                          : "marked below, and not pooled with others in means and ratios");
    for (std::size_t i = 0; i < std::min(bad.size(), kMaxBadListed); ++i)
      text += fmt::format("    {}: {}\n", statistics::PlaceText(file_, bad[i].cell), bad[i].why);
    if (bad.size() > kMaxBadListed)
      text += fmt::format("    and {} more\n", bad.size() - kMaxBadListed);
    return text + fmt::format("  To repeat only the first of them: {}\n",
                              statistics::OnlyCommand(file_, bad[0].cell));
  }

  const store::ResultFile& file_;
  const HeadParts& parts_;
  const statistics::CellGroups& groups_;
  std::vector<Cell> measured_;  ///< the sound cells; if there are none, the others
};

}  // namespace

std::string SummaryHead(const store::ResultFile& file, const HeadParts& parts) {
  return Head(file, parts).Text();
}

}  // namespace cdb::report
