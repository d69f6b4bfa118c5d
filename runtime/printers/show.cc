#include "runtime/printers/show.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "compiler/schema/catalogue.h"
#include "compiler/schema/components.h"
#include "compiler/schema/metrics.h"
#include "compiler/schema/schema.h"
#include "runtime/figures/conclusions.h"
#include "runtime/figures/coverage.h"
#include "runtime/figures/model.h"
#include "runtime/figures/requirements.h"
#include "runtime/figures/searches/searches.h"
#include "runtime/figures/steady/steady_state.h"
#include "runtime/printers/document.h"
#include "runtime/terminal/console.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

/// The axes that make the rows of each table.
std::vector<std::vector<std::size_t>> ChooseTables(const figures::Model& model,
                                                   const std::vector<std::size_t>& asked) {
  if (!asked.empty()) return {asked};
  const std::vector<std::size_t> all = figures::AllAxes(model.file());
  if (model.points().size() <= kMaxRows) return {all};
  // A mean over detectors says little: each of them has its rows.
  const auto detectors = model.ComparedDetectors();
  std::vector<std::vector<std::size_t>> tables;
  if (detectors) tables.push_back({*detectors});
  for (const std::size_t axis : all)
    if (!detectors)
      tables.push_back({axis});
    else if (axis != *detectors)
      tables.push_back({axis, *detectors});
  return tables;
}

/// The table for the `budget` of the scenario, if it has one.
void AddBudget(const figures::Model& model, bool has_answer, Document& document) {
  const auto budget = figures::BudgetOfScenario(model.file());
  if (!budget || !model.HasTimes()) return;
  document.push_back(BudgetSection(model.slow(), *budget, protocol::Phase::kStep, has_answer));
}

/// One table that fits a screen: the times by the first axes, or by one axis if there are many.
Document Brief(const figures::Model& model) {
  Document document = {BriefHead(model)};
  AddBoundaries(model, document);
  AddRaces(model, document);
  AddRequirements(model, document);
  Document tables;
  const auto by = ChooseTables(model, {});
  AddPhases(model, by.front(), {}, tables);
  if (!tables.empty()) document.push_back(std::move(tables.front()));
  AddPairs(model, by.front(), document);
  AddCounters(model, by.front(), {protocol::Phase::kStep}, document);
  AddQueries(model, by.front(), document);
  AddConfigurations(model, by.front(), document);
  AddBudget(model, false, document);  // the answer is in the head
  Section doubts = BriefDoubts(model);
  if (!doubts.lines.empty()) document.push_back(std::move(doubts));
  return document;
}

}  // namespace

Printed Show(const results::ResultFile& file, const ShowOptions& options) {
  std::vector<std::size_t> asked;
  for (const std::string& name : options.by) asked.push_back(figures::FindAxis(file, name));
  const figures::Model model(file,
                             {.only_sound = options.only_sound, .statistic = options.statistic});
  if (options.is_brief)
    return {TextOf(Brief(model), options.format), model.bad_count(),
            figures::CountNotMet(model.requirements())};
  // Whoever asks for certain rows does not ask how the file is stored.
  Document document = {SummaryHead(model, asked.empty())};
  AddBoundaries(model, document);
  AddRaces(model, document);
  AddRequirements(model, document);
  for (const auto& by : ChooseTables(model, asked)) {
    AddPhases(model, by, options.phases, document);
    AddPairs(model, by, document);
    AddCounters(model, by, options.phases, document);
    AddQueries(model, by, document);
    AddConfigurations(model, by, document);
  }
  AddDetectors(model, asked, options.phases, document);
  AddRatios(model, options.baseline, options.phases, document);
  AddOtherFaults(model, document);
  AddBudget(model, true, document);
  if (options.plots) AddPlots(model, options.phases, document);
  return {TextOf(document, options.format), model.bad_count(),
          figures::CountNotMet(model.requirements())};
}

std::string MoreText(const results::ResultFile& file, const std::string& name) {
  return fmt::format(
      "\n  All tables: cdb show {0} --all. As a page: cdb report {0} --open\n"
      "  For a paper: cdb show {0} --table {1} --latex, and cdb show {0} --method\n",
      terminal::ShellWord(name), file.Has("duration") ? "step" : "pairs");
}

RowTable::RowTable(const results::ResultFile& file, const figures::Rows& rows)
    : file_(file), rows_(rows) {
  AddAxes(file, rows.by, table_);
  if (rows.pools) table_.AddColumn("cells", true);
}

void RowTable::AddRow(const figures::Row& row, const std::vector<std::string>& figures,
                      const std::string& note) {
  std::vector<std::string> cells = Coordinates(file_, rows_.by, row.at);
  if (rows_.pools) cells.push_back(row.CellsText());
  cells.insert(cells.end(), figures.begin(), figures.end());
  const std::string both = note + (note.empty() || row.mark.empty() ? "" : ", ") + row.mark;
  if (!both.empty()) cells.push_back(both);
  has_notes_ = has_notes_ || !both.empty();
  table_.rows.push_back(std::move(cells));
}

Table RowTable::Take() {
  if (has_notes_) table_.AddColumn("", false);
  return std::move(table_);
}

void AddAxes(const results::ResultFile& file, const std::vector<std::size_t>& axes, Table& table) {
  for (const std::size_t axis : axes)
    table.AddColumn(file.axes()[axis].name, !file.axes()[axis].IsText());
  table.keys = axes.size();
}

std::vector<std::string> Coordinates(const results::ResultFile& file,
                                     const std::vector<std::size_t>& axes,
                                     const figures::Point& at) {
  std::vector<std::string> cells;
  for (std::size_t i = 0; i < at.size(); ++i)
    cells.push_back(terminal::CoordinateText(file.axes()[axes[i]], at[i]));
  return cells;
}

namespace {

using figures::Cell;
using figures::CellGroups;
using Lines = std::vector<std::string>;

constexpr std::size_t kMaxBadListed = 8;
/// A smaller fraction of the tensor without values is not reported.
constexpr double kNoticeablePadding = 0.05;

void Add(Lines& lines, const Lines& more) { lines.insert(lines.end(), more.begin(), more.end()); }
void Add(Lines& lines, std::string line) {
  if (!line.empty()) lines.push_back(std::move(line));
}

bool MayMissPairs(const std::string& detector) {
  const schema::DetectorInfo* info = schema::FindDetector(detector);
  return info != nullptr && info->Makes(schema::KnownErrors::kMissesPairs);
}

class Head {
 public:
  explicit Head(const figures::Model& model)
      : model_(model), file_(model.file()), groups_(model.runs()), measured_(groups_.good) {
    if (!measured_.empty()) return;
    for (const CellGroups::Bad& bad : groups_.bad) measured_.push_back(bad.cell);
  }

  Section Made(bool has_padding) const {
    Lines lines = {Grid()};
    Add(lines, AxisTitles());
    if (has_padding) Add(lines, Padding());
    Add(lines, Cautions());
    Add(lines, HarnessNote(model_));
    Add(lines, figures::SortingText(file_));
    Add(lines, LeftOut());
    Add(lines, Models());
    Add(lines, Verdicts());
    Add(lines, figures::SameMotionText(file_));
    Add(lines, figures::OpenQuestionsText(file_, Judged()));
    Add(lines, figures::SleepNote(file_, measured_));
    Add(lines, steady::SteadyText(steady::FindSteadyStates(model_)));
    Add(lines, Errors());
    Add(lines, Missing());
    Add(lines, BadRuns());
    return {.title = file_.title(), .lines = std::move(lines)};
  }

  Section Answers() const {
    constexpr std::size_t kMostAnswers = 3;
    Lines lines = {Grid()};
    Add(lines, AxisTitles());
    std::size_t count = 0;
    for (const figures::Conclusion& conclusion : ConclusionsOf(model_)) {
      // Whether the others can be believed.
      const bool is_about_soundness = conclusion.kind == "stability";
      if (++count > kMostAnswers && !is_about_soundness) continue;
      lines.push_back(conclusion.question);
      lines.push_back("  " + conclusion.answer);
    }
    return {.title = file_.title(), .lines = std::move(lines)};
  }

  Section Doubts() const {
    Lines lines = Cautions();
    if (Lines doubts = Verdicts(); doubts.size() > 1) Add(lines, doubts);
    Add(lines, Missing());
    Add(lines, BadRuns());
    return {.lines = std::move(lines)};
  }

 private:
  /// Why the figures may not be trusted.
  Lines Cautions() const {
    Lines lines;
    Add(lines, NoiseNote(file_, measured_));
    Add(lines, ProcessorNotes(file_, measured_));
    Add(lines, WrongDetectors(model_));
    Add(lines, BuildNote(file_));
    Add(lines, JobsNote(file_));
    Add(lines, figures::ReferenceTexts(model_));
    return lines;
  }

  std::string Missing() const {
    if (groups_.missing == 0) return {};
    const std::uint64_t begun = file_.begun_repeats(), all = file_.repeats();
    const bool are_late = groups_.missing * all == (all - begun) * groups_.NotSkipped();
    return fmt::format(
        "{} not run yet{}.", groups_.missing,
        are_late ? fmt::format(": repeats {} to {} of each point", begun + 1, all) : "");
  }

  /// The number of runs.
  std::string Grid() const {
    const std::string grid = terminal::GridText(file_.axes(), file_.repeats());
    const std::size_t cells = groups_.NotSkipped();
    std::uint64_t least = file_.cycles();
    for (const Cell& cell : groups_.good) least = std::min(least, file_.ReadCycleCount(cell));
    std::string text =
        fmt::format("{} {}{}, {}{} cycles", cells, cells == 1 ? "run" : "runs",
                    grid.empty() ? "" : " (" + grid + ")",
                    least < file_.cycles() ? fmt::format("{} to ", least) : "", file_.cycles());
    if (const std::string time = SimulatedTime(model_); !time.empty())
      text += fmt::format(" ({} simulated)", time);
    if (groups_.skipped > 0)
      text += fmt::format(", {} {}", groups_.skipped,
                          plan::ChoosesRuns(file_.axes()) ? "not needed" : "skipped");
    return text;
  }

  /// `n: number of layers; d: drop height`
  std::string AxisTitles() const {
    std::string text;
    for (const plan::Axis& axis : file_.axes())
      if (!axis.title.empty())
        text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", axis.name, axis.title);
    return text;
  }

  /// The tensor is as long as the longest run; cycles beyond the end of shorter ones have no
  /// values.
  std::string Padding() const {
    std::uint64_t all = 0;
    for (const Cell& cell : groups_.good) all += file_.ReadCycleCount(cell);
    const double room = static_cast<double>(groups_.good.size() * file_.cycles());
    const double share = room > 0 ? 1 - static_cast<double>(all) / room : 0;
    if (share < kNoticeablePadding) return {};
    return fmt::format("{:.0f} % of the arrays over cycles in the file is padding of shorter runs.",
                       100 * share);
  }

  /// The command that shows the errors, if the file has any.
  std::string Errors() const {
    std::string names;
    for (const schema::ErrorInfo& error : schema::Errors())
      if (file_.Has(fmt::format("accuracy/{}", error.name)))
        names += fmt::format("{}{}", names.empty() ? "" : ", ", error.name);
    return names.empty() ? names : fmt::format("Errors, by cdb show --error: {}.", names);
  }

  /// How sound the physics of the runs in the figures is. Empty if no run was judged.
  Lines Verdicts() const {
    Lines doubts;
    std::size_t unsound = 0;
    for (auto row = groups_.verdicts.rbegin(); row != groups_.verdicts.rend(); ++row) {
      const auto& [verdict, runs] = *row;
      if (verdict <= protocol::Verdict::kStable) continue;
      unsound += runs.size();
      const std::string objects = figures::BadObjectsText(file_, runs[0].cell);
      const std::string criterion = file_.ReadJudgement(runs[0].cell).criterion;
      doubts.push_back(fmt::format(
          "  {} {}: {}{} from cycle {} on{}{}", runs.size(), protocol::VerdictName(verdict),
          figures::PlaceText(file_, runs[0].cell),
          criterion.empty() || criterion == protocol::VerdictName(verdict) ? ""
                                                                           : " by " + criterion,
          runs[0].first_bad_cycle, objects.empty() ? "" : ", " + objects,
          runs.size() > 1 ? "; and others" : ""));
    }
    const auto stable = groups_.verdicts.find(protocol::Verdict::kStable);
    const std::size_t sound = stable == groups_.verdicts.end() ? 0 : stable->second.size();
    if (doubts.empty()) {
      if (sound == 0) return {};
      const std::size_t runs = groups_.NotSkipped();
      const std::string checked =
          fmt::format("{}", fmt::join(figures::CheckedQuestions(file_, Judged()), ", "));
      const bool is_open = figures::LeavesVitalOpen(file_, Judged());
      const std::string by = is_open           ? fmt::format(", as far as was checked ({})",
                                                   checked.empty() ? "nothing" : checked)
                             : checked.empty() ? ""
                                               : fmt::format(" (checked: {})", checked);
      return {sound < runs ? fmt::format("Verdict: {} of {} stable{}.", sound, runs, by)
                           : fmt::format("Verdict: {}stable{}.", sound > 1 ? "all " : "", by)};
    }
    doubts.insert(
        doubts.begin(),
        unsound + sound == 1
            ? std::string("Not stable: its time is shown, but is that of another motion "
                          "(cdb doc verdicts):")
            : fmt::format("Not stable: {}; their times are shown, but are those of another motion "
                          "(cdb doc verdicts):",
                          RunsText(unsound, unsound + sound)));
    return doubts;
  }

  /// The runs with a verdict.
  std::vector<Cell> Judged() const {
    std::vector<Cell> judged;
    for (const Cell& cell : measured_)
      if (figures::EndingOf(file_, cell).judgement.verdict != protocol::Verdict::kUnknown)
        judged.push_back(cell);
    return judged;
  }

  /// How well the convex hulls approximate the models of the scene, a line for each.
  Lines Models() const {
    std::set<std::string> lines;
    std::istringstream all(file_.ReadProvenance("models"));
    for (std::string line; std::getline(all, line);) {
      // The texts of several runs are joined.
      if (line.starts_with("; ")) line.erase(0, 2);
      if (!line.empty()) lines.insert(line);
    }
    return {lines.begin(), lines.end()};
  }

  /// The omissions, and the number of runs with each.
  Lines LeftOut() const {
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
    Lines lines;
    for (const auto& [count, names] : by_count) {
      const std::string where = count < measured_.size()
                                    ? fmt::format(" in {} of {} runs", count, measured_.size())
                                : count > 1 ? fmt::format(" in all {} runs", count)
                                            : std::string();
      lines.push_back(fmt::format("Omitted{}: {}.", where, names));
    }
    if (!lines.empty()) lines.back() += " omit none times everything.";
    return lines;
  }

  /// `40 frozen, 5 failed`.
  std::string Faults() const {
    std::map<std::string, std::size_t> counts;
    for (const CellGroups::Bad& bad : groups_.bad)
      ++counts[figures::EndingOf(file_, bad.cell).Word()];
    std::string text;
    for (const auto& [fault, count] : counts)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, fault);
    return text;
  }

  /// Runs that are not pooled with others in any figure.
  Lines BadRuns() const {
    const auto& bad = groups_.bad;
    if (bad.empty()) return {};
    Lines lines = {fmt::format(
        "{} did not end well ({}), {}:", bad.size(), Faults(),
        model_.only_sound() ? "excluded by --sound"
                            : "marked below, and not pooled with others in means and ratios")};
    for (std::size_t i = 0; i < std::min(bad.size(), kMaxBadListed); ++i)
      lines.push_back(fmt::format("  {}: {}", figures::PlaceText(file_, bad[i].cell), bad[i].why));
    if (bad.size() > kMaxBadListed)
      lines.push_back(fmt::format("  and {} more", bad.size() - kMaxBadListed));
    lines.push_back(fmt::format("To repeat only the first of them: {}",
                                figures::OnlyCommand(file_, bad[0].cell)));
    return lines;
  }

  const figures::Model& model_;
  const results::ResultFile& file_;
  const CellGroups& groups_;
  std::vector<Cell> measured_;  ///< the sound cells; if there are none, the others
};

}  // namespace

Section SummaryHead(const figures::Model& model, bool has_padding) {
  return Head(model).Made(has_padding);
}
Section BriefHead(const figures::Model& model) { return Head(model).Answers(); }
Section BriefDoubts(const figures::Model& model) { return Head(model).Doubts(); }

std::vector<std::string> WrongDetectors(const figures::Model& model) {
  Lines lines;
  for (const figures::DetectorFindings& of : model.findings()) {
    if (of.missed == 0) continue;
    lines.push_back(fmt::format(
        "WRONG: {} missed {} of {} pairs, in {} of {} {}; first in cycle {} of {}.", of.detector,
        of.missed, of.exact, of.wrong_runs, of.runs, of.runs == 1 ? "run" : "runs",
        of.first_missed->cycle, figures::PlaceText(model.file(), of.first_missed->cell)));
    lines.push_back(
        fmt::format("  Its times are of less work than necessary. To repeat that run: {}",
                    figures::OnlyCommand(model.file(), of.first_missed->cell)));
  }
  Lines names;
  for (const figures::DetectorFindings& of : model.findings())
    if (of.missed == 0 && of.unwatched_runs > 0 && MayMissPairs(of.detector))
      names.push_back(of.detector);
  if (!names.empty())
    lines.push_back(
        fmt::format("Known to miss pairs, but not checked: {}. `record pairs` checks them.",
                    fmt::join(names, ", ")));
  return lines;
}

}  // namespace cdb::printers
