#include "runtime/report/show.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>

#include "compiler/plan/pruning.h"
#include "compiler/schema/metrics.h"
#include "compiler/schema/schema.h"
#include "runtime/report/cells.h"
#include "runtime/report/findings.h"
#include "runtime/report/show_detectors.h"
#include "runtime/report/table.h"

namespace cdb::report {
namespace {

using Cell = store::ResultFile::Cell;
using plan::Axis;

constexpr std::size_t kMaxBadListed = 8;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// `needs` says that the component was there: not left out, and not absent from the scene anyway.
bool SaysKept(std::string_view needs, std::string_view component) {
  const std::string line = fmt::format("{}: kept: ", component);
  for (std::size_t at = needs.find(line); at != needs.npos; at = needs.find(line, at + 1))
    if (at == 0 || needs[at - 1] == '\n') return true;
  return false;
}

/// What a row or a column of a summary is made from: values of many cells, sorted when all are in.
struct Pool {
  std::array<std::vector<double>, measure::kPhaseCount> phases;
  std::vector<double> pairs, contacts;

  void Sort() {
    for (auto& phase : phases) std::ranges::sort(phase);
    std::ranges::sort(pairs);
    std::ranges::sort(contacts);
  }
};

class Summary {
 public:
  explicit Summary(const store::ResultFile& file) : file_(file) {
    for (const Cell& cell : AllCells(file)) Sort(cell);
  }

  ShowText Text(const ShowOptions& options) {
    std::string text = Head();
    std::vector<std::size_t> all(file_.axes().size());
    std::size_t rows = 1;
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i] = i;
      rows *= file_.axes()[i].values.size();
    }
    std::vector<std::vector<std::size_t>> tables;
    std::vector<std::size_t> by_detector;
    if (!options.by.empty()) {
      tables.emplace_back();
      for (const std::string& name : options.by) tables.back().push_back(FindAxis(file_, name));
      by_detector = tables.back();
    } else if (rows <= kMaxRows) {
      tables.push_back(all);
    } else {
      for (const std::size_t axis : all) tables.push_back({axis});
    }
    if (!good_.empty())
      for (const auto& by : tables) text += Tables(by);
    text += ShowDetectors(file_, good_, by_detector) + Ratios(all) + OtherFaults(findings_);
    return {text, bad_.size() + references_.size()};
  }

 private:
  struct Bad {
    Cell cell;
    std::string why;
  };

  void Sort(const Cell& cell) {
    const store::Status status = file_.ReadStatus(cell);
    if (status == store::Status::kSkipped) {
      ++skipped_;
    } else if (status == store::Status::kMissing) {
      ++missing_;
    } else if (const auto trouble = Trouble(file_, cell)) {
      bad_.push_back({cell, *trouble});
    } else {
      const measure::Judgement judgement = file_.ReadJudgement(cell);
      good_.push_back(cell);
      verdicts_[judgement.verdict].push_back({cell, judgement.first_bad_cycle});
    }
  }

  /// Where the errors are shown, if the file has any.
  std::string Errors() const {
    std::string names;
    for (const schema::ErrorInfo& error : schema::Errors())
      if (file_.Has(fmt::format("accuracy/{}", error.name)))
        names += fmt::format("{}{}", names.empty() ? "" : ", ", error.name);
    return names.empty() ? names : fmt::format("  Errors, by cdb show --error: {}.\n", names);
  }

  /// What the physics of the runs in the figures is worth. Nothing where no run was judged.
  std::string Verdicts() const {
    std::string doubts;
    for (auto row = verdicts_.rbegin(); row != verdicts_.rend(); ++row) {
      const auto& [verdict, runs] = *row;
      if (verdict <= measure::Verdict::kStable) continue;
      doubts += fmt::format("    {} {}: {} from cycle {} on{}\n", runs.size(),
                            measure::VerdictName(verdict), PlaceText(file_, runs[0].cell),
                            runs[0].first_bad_cycle, runs.size() > 1 ? ", and others" : "");
    }
    const auto stable = verdicts_.find(measure::Verdict::kStable);
    const std::size_t sound = stable == verdicts_.end() ? 0 : stable->second.size();
    if (doubts.empty())
      return sound == 0 ? "" : fmt::format("  Verdict: {}stable.\n", sound > 1 ? "all " : "");
    return fmt::format("  {} stable; in the figures below, but not sound (cdb doc verdicts):\n{}",
                       sound, doubts);
  }

  /// How well convex hulls stand for the models of the scene, a line for each.
  std::string Models() const {
    std::set<std::string> lines;
    std::istringstream all(file_.ReadProvenance("models"));
    for (std::string line; std::getline(all, line);) {
      // Texts of several runs are joined.
      if (line.starts_with("; ")) line.erase(0, 2);
      if (!line.empty()) lines.insert(line);
    }
    std::string text;
    for (const std::string& line : lines) text += fmt::format("  {}\n", line);
    return text;
  }

  std::string Head() const {
    std::string text = file_.title() + "\n";
    std::string grid;
    for (const Axis& axis : file_.axes())
      grid += fmt::format("{}{} {}", grid.empty() ? "" : " x ", axis.values.size(), axis.name);
    if (file_.repeats() > 1)
      grid += fmt::format("{}{} rep", grid.empty() ? "" : " x ", file_.repeats());
    const std::size_t cells = good_.size() + bad_.size() + missing_;
    text += fmt::format("  {} {}{}, {} cycles", cells, cells == 1 ? "run" : "runs",
                        grid.empty() ? "" : " (" + grid + ")", file_.cycles());
    if (skipped_ > 0) text += fmt::format(", {} left out by skip", skipped_);
    text += '\n';
    text += WrongDetectors(file_, findings_);
    const std::string build = file_.ReadProvenance("build_type");
    if (build != "Release")
      text +=
          fmt::format("  Timed with a {} build of cdb: these are not timings to quote.\n", build);
    if (const std::string jobs = file_.ReadProvenance("jobs"); !jobs.empty() && jobs != "1")
      text += fmt::format(
          "  Timed with several runs at a time (jobs {}), which disturb each other.\n", jobs);
    for (const std::string& trouble : references_)
      text += fmt::format("  What runs are held against is not there: {}\n", trouble);
    text += HarnessText(file_, good_) + LeftOut() + Models() + Verdicts() + Errors();
    if (missing_ > 0) text += fmt::format("  {} not run yet.\n", missing_);
    if (!bad_.empty()) {
      text += fmt::format("  {} did not end well and {} in no figure below:\n", bad_.size(),
                          bad_.size() == 1 ? "is" : "are");
      for (std::size_t i = 0; i < std::min(bad_.size(), kMaxBadListed); ++i)
        text += fmt::format("    {}: {}\n", PlaceText(file_, bad_[i].cell), bad_[i].why);
      if (bad_.size() > kMaxBadListed)
        text += fmt::format("    and {} more\n", bad_.size() - kMaxBadListed);
      text += fmt::format("  To run the first of them by itself: {}\n",
                          OnlyCommand(file_, bad_[0].cell));
    }
    return text;
  }

  /// What the measurement is without, and in how many of the runs that ended well.
  std::string LeftOut() const {
    if (!file_.Has("omitted")) return {};
    std::map<std::size_t, std::string, std::greater<>> by_count;
    for (const schema::ComponentInfo& info : schema::Components()) {
      if (!info.IsVisible()) continue;
      const auto count =
          static_cast<std::size_t>(std::ranges::count_if(good_, [&](const Cell& cell) {
            return schema::ListsWord(file_.ReadText("omitted", cell), info.name);
          }));
      if (count == 0) continue;
      std::string& names = by_count[count];
      names += fmt::format("{}{} ({})", names.empty() ? "" : ", ", info.name, info.changes);
    }
    std::string text;
    for (const auto& [count, names] : by_count) {
      const std::string where = count < good_.size()
                                    ? fmt::format(" in {} of {} runs", count, good_.size())
                                : count > 1 ? fmt::format(" in all {} runs", count)
                                            : std::string();
      text += fmt::format("{}  Left out{}: {}.", text.empty() ? "" : "\n", where, names);
    }
    return text.empty() ? text : text + " omit none times everything.\n";
  }

  std::map<std::vector<std::size_t>, Pool> Pools(const std::vector<std::size_t>& by) const {
    std::map<std::vector<std::size_t>, Pool> pools;
    for (const Cell& cell : good_) {
      std::vector<std::size_t> key;
      for (const std::size_t axis : by) key.push_back(cell.at[axis]);
      Pool& pool = pools[key];
      const auto append = [](std::vector<double>& to, const std::vector<double>& values) {
        to.insert(to.end(), values.begin(), values.end());
      };
      if (file_.Has("duration"))
        for (std::size_t phase = 0; phase < measure::kPhaseCount; ++phase)
          append(pool.phases[static_cast<std::size_t>(phase)],
                 file_.ReadDuration(static_cast<measure::Phase>(phase), cell));
      if (file_.Has("pairs")) append(pool.pairs, file_.ReadSeries("pairs", cell));
      if (file_.Has("contacts")) append(pool.contacts, file_.ReadSeries("contacts", cell));
    }
    for (auto& [key, pool] : pools) pool.Sort();
    return pools;
  }

  std::string Tables(const std::vector<std::size_t>& by) const {
    const auto pools = Pools(by);
    TimeUnit unit = TimeUnit::For(0);
    if (file_.Has("duration")) {
      std::vector<double> steps;
      for (const auto& [key, pool] : pools)
        steps.push_back(Percentile(pool.phases[measure::IndexOf(measure::Phase::kStep)], 0.5));
      std::ranges::sort(steps);
      unit = TimeUnit::For(Percentile(steps, 0.5));
    }
    Table medians, spread;
    for (Table* table : {&medians, &spread}) {
      for (const std::size_t axis : by)
        table->AddColumn(file_.axes()[axis].name, !file_.axes()[axis].IsText());
      if (file_.Has("duration"))
        for (const std::string_view phase : measure::PhaseNames())
          table->AddColumn(std::string(phase), true);
    }
    if (file_.Has("pairs")) medians.AddColumn("pairs", true);
    if (file_.Has("contacts")) medians.AddColumn("contacts", true);
    for (const auto& [key, pool] : pools) {
      std::vector<std::string> middle, ends;
      for (std::size_t i = 0; i < by.size(); ++i)
        middle.push_back(CoordinateText(file_.axes()[by[i]], key[i]));
      ends = middle;
      if (file_.Has("duration")) {
        for (const auto& phase : pool.phases) {
          const auto number = [&](double p) { return ShortNumber(Percentile(phase, p) / unit.ns); };
          middle.push_back(number(0.5));
          ends.push_back(number(0.05) + " .. " + number(0.95));
        }
      }
      if (file_.Has("pairs")) middle.push_back(ShortNumber(Percentile(pool.pairs, 0.5)));
      if (file_.Has("contacts")) middle.push_back(ShortNumber(Percentile(pool.contacts, 0.5)));
      medians.AddRow(std::move(middle));
      spread.AddRow(std::move(ends));
    }
    std::string text;
    if (file_.Has("duration")) {
      text += fmt::format("\nMedian of a cycle, {}\n{}", unit.name, medians.Text());
      text += fmt::format("\n5th .. 95th percentile, {}\n{}", unit.name, spread.Text());
    } else if (file_.Has("pairs")) {
      text += fmt::format("\nMedian of a cycle\n{}", medians.Text());
    }
    return text;
  }

  /// A line where detectors that are compared at one point did not leave out the same.
  std::string Unlike(std::size_t detector) const {
    if (!file_.Has("omitted") || !file_.Has("needs")) return {};
    std::map<std::pair<std::vector<std::size_t>, std::uint64_t>, std::vector<const Cell*>> points;
    for (const Cell& cell : good_) {
      std::vector<std::size_t> key = cell.at;
      key.erase(key.begin() + static_cast<std::ptrdiff_t>(detector));
      points[{key, cell.rep}].push_back(&cell);
    }
    std::size_t unlike_points = 0;
    std::vector<bool> unlike(schema::Components().size());
    for (const auto& [key, rivals] : points) {
      bool is_unlike = false;
      for (std::size_t i = 0; i < unlike.size(); ++i) {
        const schema::ComponentInfo& info = schema::Components()[i];
        if (!info.IsVisible()) continue;
        const bool differs = std::ranges::any_of(rivals,
                                                 [&](const Cell* cell) {
                                                   return schema::ListsWord(
                                                       file_.ReadText("omitted", *cell), info.name);
                                                 }) &&
                             std::ranges::any_of(rivals, [&](const Cell* cell) {
                               return SaysKept(file_.ReadText("needs", *cell), info.name);
                             });
        unlike[i] = unlike[i] || differs;
        is_unlike = is_unlike || differs;
      }
      unlike_points += is_unlike ? 1 : 0;
    }
    if (unlike_points == 0) return {};
    std::string names;
    for (std::size_t i = 0; i < unlike.size(); ++i)
      if (unlike[i])
        names += fmt::format("{}{}", names.empty() ? "" : ", ", schema::Components()[i].name);
    return fmt::format(
        "\nAt {} of {} points some detectors ran without {} and others with: their ratios there "
        "are not of the detectors alone. omit none makes them alike.\n",
        unlike_points, points.size(), names);
  }

  /// Each detector against the first, at every point of the other axes.
  std::string Ratios(const std::vector<std::size_t>& all) const {
    const auto found = DetectorAxis(file_);
    if (!found || file_.axes()[*found].values.size() < 2 || !file_.Has("duration")) return {};
    const std::size_t d = *found;
    const Axis* detector = &file_.axes()[d];
    std::vector<std::size_t> others = all;
    std::erase(others, d);

    struct Medians {
      std::vector<std::array<double, 2>> by_detector;  // detect, step
    };
    std::map<std::pair<std::vector<std::size_t>, std::uint64_t>, Medians> points;
    for (const Cell& cell : good_) {
      std::vector<std::size_t> key;
      for (const std::size_t axis : others) key.push_back(cell.at[axis]);
      auto& medians = points[{key, cell.rep}].by_detector;
      medians.resize(detector->values.size(), {kNone, kNone});
      for (const auto& [slot, phase] :
           {std::pair{0, measure::Phase::kDetect}, std::pair{1, measure::Phase::kStep}}) {
        auto values = file_.ReadDuration(phase, cell);
        std::ranges::sort(values);
        medians[cell.at[d]][static_cast<std::size_t>(slot)] = Percentile(values, 0.5);
      }
    }
    std::string text = Unlike(d);
    for (const auto& [slot, phase] :
         {std::pair{std::size_t{0}, "detect"}, std::pair{std::size_t{1}, "step"}}) {
      Table table;
      for (const std::size_t axis : others)
        table.AddColumn(file_.axes()[axis].name, !file_.axes()[axis].IsText());
      if (file_.repeats() > 1) table.AddColumn("rep", true);
      if (others.empty() && file_.repeats() == 1) table.AddColumn("", false);
      for (std::size_t i = 0; i < detector->values.size(); ++i)
        table.AddColumn(CoordinateText(*detector, i), true);
      std::vector<std::vector<double>> ratios(detector->values.size());
      for (const auto& [key, medians] : points) {
        std::vector<std::string> row;
        for (std::size_t i = 0; i < others.size(); ++i)
          row.push_back(CoordinateText(file_.axes()[others[i]], key.first[i]));
        if (file_.repeats() > 1) row.push_back(fmt::format("{}", key.second));
        if (others.empty() && file_.repeats() == 1) row.emplace_back();
        for (std::size_t i = 0; i < medians.by_detector.size(); ++i) {
          const double ratio = medians.by_detector[i][slot] / medians.by_detector[0][slot];
          row.push_back(ShortNumber(ratio));
          if (std::isfinite(ratio)) ratios[i].push_back(ratio);
        }
        if (points.size() <= kMaxRows) table.AddRow(std::move(row));
      }
      if (points.size() > 1) {
        std::vector<std::string> mean(others.size() + (file_.repeats() > 1 ? 1 : 0)), range;
        mean[0] = "mean";
        range = mean;
        range[0] = "range";
        for (auto& of_detector : ratios) {
          double log = 0;
          for (const double ratio : of_detector) log += std::log(ratio);
          std::ranges::sort(of_detector);
          mean.push_back(ShortNumber(std::exp(log / static_cast<double>(of_detector.size()))));
          range.push_back(of_detector.empty() ? "-"
                                              : ShortNumber(of_detector.front()) + " .. " +
                                                    ShortNumber(of_detector.back()));
        }
        table.AddRow(std::move(mean));
        table.AddRow(std::move(range));
      }
      text +=
          fmt::format("\nMedian of {} over that of {}{}\n{}", phase, CoordinateText(*detector, 0),
                      points.size() > 1 ? " (geometric mean below)" : "", table.Text());
    }
    return text;
  }

  const store::ResultFile& file_;
  const std::vector<std::string> references_ = file_.ReadReferenceTroubles();  ///< that fail
  const std::vector<DetectorFindings> findings_ = FindingsOf(file_);
  std::vector<Cell> good_;
  std::vector<Bad> bad_;
  struct Judged {
    Cell cell;
    std::int64_t first_bad_cycle;
  };
  std::map<measure::Verdict, std::vector<Judged>> verdicts_;  ///< of the good ones
  std::size_t skipped_ = 0, missing_ = 0;
};

}  // namespace

std::size_t FindAxis(const store::ResultFile& file, const std::string& name) {
  std::string names;
  for (std::size_t i = 0; i < file.axes().size(); ++i) {
    if (file.axes()[i].name == name) return i;
    names += (i == 0 ? "" : ", ") + file.axes()[i].name;
  }
  throw store::StoreError(names.empty()
                              ? fmt::format("there is no axis '{}': this file has none", name)
                              : fmt::format("there is no axis '{}'; there are {}", name, names));
}

std::optional<std::string> Trouble(const store::ResultFile& file,
                                   const store::ResultFile::Cell& cell) {
  const store::Status status = file.ReadStatus(cell);
  if (status == store::Status::kMissing) return "not run yet";
  if (status != store::Status::kDone) {
    const std::string message = file.ReadText("message", cell);
    return std::string(store::StatusName(status)) + (message.empty() ? "" : ": ") + message;
  }
  const measure::Judgement judgement = file.ReadJudgement(cell);
  if (!measure::HasVoidTimings(judgement.verdict)) return std::nullopt;
  return fmt::format("{} from cycle {} on", measure::VerdictName(judgement.verdict),
                     judgement.first_bad_cycle);
}

double Percentile(const std::vector<double>& sorted, double p) {
  if (sorted.empty()) return kNone;
  const double place = p * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<std::size_t>(place);
  const std::size_t high = std::min(low + 1, sorted.size() - 1);
  return std::lerp(sorted[low], sorted[high], place - static_cast<double>(low));
}

ShowText Show(const store::ResultFile& file, const ShowOptions& options) {
  return Summary(file).Text(options);
}

}  // namespace cdb::report
