#include "runtime/printers/results_document.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "compiler/schema/components.h"
#include "compiler/schema/metrics.h"
#include "runtime/figures/bootstrap.h"
#include "runtime/figures/conclusions.h"
#include "runtime/figures/coverage.h"
#include "runtime/figures/errors.h"
#include "runtime/figures/model.h"
#include "runtime/figures/requirements.h"
#include "runtime/printers/document.h"
#include "runtime/printers/json_points.h"
#include "runtime/printers/show.h"

namespace cdb::printers {
namespace {

constexpr int kVersion = 1;
/// Limit of failures on a page.
constexpr std::size_t kMaxFailures = 200;

std::string GeneratorOf(const results::ResultFile& file) {
  const std::string version = file.ReadProvenance("cdb_version");
  return version.empty() ? "cdb" : "cdb " + version;
}

Json IntervalWords(const figures::Model& model) {
  const figures::CycleTimes& times = model.times();
  const std::string name = times.IntervalName();
  return {{"name", name.empty() ? Json(nullptr) : Json(name)}, {"text", times.IntervalNote()}};
}

Json DocumentConclusions(const figures::Model& model) {
  Json all = Json::array();
  if (IsLarge(model)) return all;
  for (const figures::Conclusion& of : ConclusionsOf(model)) {
    Json conclusion = {{"question", of.question},
                       {"answer", of.answer},
                       {"kind", of.kind},
                       {"certainty", figures::CertaintyName(of.certainty)}};
    if (of.effect)
      conclusion["effect"] = {
          {"axis", of.effect->axis},
          {"from", of.effect->from},
          {"to", of.effect->to},
          {"ratio", of.effect->ratio},
          {"low", of.effect->interval ? Json(of.effect->interval->first) : Json()},
          {"high", of.effect->interval ? Json(of.effect->interval->second) : Json()}};
    all.push_back(std::move(conclusion));
  }
  return all;
}

Json DocumentBudget(const figures::Model& model) {
  const auto budget = figures::BudgetOfScenario(model.file());
  if (!budget || !model.HasTimes() || IsLarge(model)) return nullptr;
  Json points = Json::array();
  const auto all = figures::BudgetOf(model.slow(), *budget, protocol::Phase::kStep);
  for (const figures::BudgetFigures& of : all)
    points.push_back({{"point", model.IndexOf(of.point->at)},
                      {"ns", JsonNumber(of.budget_ns, 9)},
                      {"above", of.above},
                      {"cycles", of.cycles},
                      {"p99", of.p99.value},
                      {"low", of.interval ? Json(of.interval->low) : Json()},
                      {"high", of.interval ? Json(of.interval->high) : Json()},
                      {"at_least", of.at_least ? Json(*of.at_least) : Json()},
                      {"worst", of.worst},
                      {"fits", figures::FitName(of.fit)}});
  const bool is_one = std::ranges::all_of(
      all, [&](const figures::BudgetFigures& of) { return of.budget_ns == all[0].budget_ns; });
  return {{"ns", is_one && !all.empty() ? JsonNumber(all[0].budget_ns, 9) : Json()},
          {"text", budget->Text()},
          {"phase", "step"},
          {"points", std::move(points)}};
}

Json DocumentRequirements(const figures::Model& model) {
  Json all = Json::array();
  const bool has_points = !IsLarge(model);
  const std::string interval = model.times().IntervalName();
  for (const figures::JudgedRequirement& of : model.requirements()) {
    Json points = Json::array();
    for (const figures::JudgedPoint& point : of.points) {
      if (!has_points) break;
      points.push_back({{"point", model.IndexOf(point.at)},
                        {"answer", figures::AnswerName(point.answer)},
                        {"value", JsonNumber(point.value, 9)},
                        {"low", JsonNumber(point.low, 9)},
                        {"high", JsonNumber(point.high, 9)},
                        {"limit", JsonNumber(point.limit, 9)},
                        {"text", figures::ReasonText(of, point, interval)}});
    }
    all.push_back({{"text", of.what.text},
                   {"budget", of.is_budget},
                   {"figure", of.what.figure.Text()},
                   {"comparison", plan::ComparisonText(of.what.comparison)},
                   {"unit", of.what.figure.Unit()},
                   {"answer", figures::AnswerName(of.Whole())},
                   {"met", of.Count(figures::Answer::kMet)},
                   {"not_met", of.Count(figures::Answer::kNotMet)},
                   {"cannot_tell", of.Count(figures::Answer::kCannotTell)},
                   {"points", std::move(points)}});
  }
  return all;
}

Json DocumentCoverage(const figures::Model& model) {
  const std::vector<figures::Cell>& cells = model.runs().good;
  Json unchecked = Json::array();
  for (const figures::OpenQuestion& open : figures::OpenQuestions(model.file(), cells))
    unchecked.push_back({{"question", open.question}, {"why", open.why}, {"runs", open.runs}});
  return {{"checked", figures::CheckedQuestions(model.file(), cells)},
          {"unchecked", std::move(unchecked)}};
}

void CheckSize(const figures::Model& model) {
  if (model.grid().size() > kMaxDocumentPoints)
    throw files::StoreError(
        fmt::format("{} points are more than a document can have ({}): select a part, by `cdb show "
                    "--json --select AXIS=VALUE`",
                    model.grid().size(), kMaxDocumentPoints));
}

using figures::GridPoint;
using figures::MeasuredPoint;

class PointTable {
 public:
  PointTable(const figures::Model& model, const std::vector<protocol::Phase>& phases)
      : model_(model), file_(model.file()) {
    table_.rows.resize(model.grid().size());
    AddAxes();
    Add("verdict", [](const GridPoint& point) { return point.ending.Word(); });
    Add("mark", [](const GridPoint& point) { return point.Mark(); });
    Add("repeats", [](const GridPoint& point) {
      return std::to_string(point.measured == nullptr ? 0 : point.measured->cells.size());
    });
    if (model.HasTimes())
      for (const protocol::Phase phase : phases.empty() ? figures::AllPhases() : phases)
        AddPhase(phase);
    for (const char* series : {"pairs", "unhandled_pairs", "manifolds", "contacts", "present",
                               "departed", "missed_pairs", "repose_angle", "runout"})
      if (file_.Has(series))
        AddNumber(series,
                  [&](const MeasuredPoint& point) { return model_.CountOf(point, series); });
    if (model_.HasNarrowTraces())
      AddNumber("ns_per_pair",
                [&](const MeasuredPoint& point) { return model_.NsPerPairOf(point); });
    if (file_.Has("peak_rss"))
      AddNumber("peak_rss_bytes",
                [&](const MeasuredPoint& point) { return model_.MemoryOf(point, "peak_rss"); });
    AddErrors();
  }

  const Table& table() const { return table_; }

 private:
  void Add(const std::string& head, const std::function<std::string(const GridPoint&)>& value) {
    table_.AddColumn(head, false);
    for (std::size_t i = 0; i < table_.rows.size(); ++i)
      table_.rows[i].push_back(value(model_.grid()[i]));
  }
  /// A numeric column for points with cycles.
  void AddNumber(const std::string& head,
                 const std::function<double(const MeasuredPoint&)>& value) {
    Add(head, [&](const GridPoint& point) {
      const double number = point.measured == nullptr ? figures::kNone : value(*point.measured);
      return std::isfinite(number) ? fmt::format("{:.6g}", number) : std::string();
    });
  }

  void AddAxes() {
    for (const std::size_t i : figures::AllAxes(file_))
      Add(model_.axis(i).name, [&](const GridPoint& point) {
        const plan::Coordinate& value = model_.axis(i).values[point.at[i]];
        if (const auto* number = std::get_if<double>(&value)) return fmt::format("{}", *number);
        return std::get<std::string>(value);
      });
  }

  void AddPhase(protocol::Phase phase) {
    const figures::CycleTimes& times = model_.times();
    const std::string name = figures::PhaseName(phase);
    const auto add = [&](const std::string& head, auto part_of) {
      AddNumber(head,
                [&](const MeasuredPoint& point) { return part_of(model_.TimeOf(point, phase)); });
    };
    using Figure = figures::Estimate;
    add(fmt::format("{}_{}_ns", name, times.StatisticName()),
        [](const Figure& figure) { return figure.value; });
    add(name + "_low_ns", [&](const Figure& figure) { return times.IntervalOf(figure).low; });
    add(name + "_high_ns", [&](const Figure& figure) { return times.IntervalOf(figure).high; });
  }

  void AddErrors() {
    for (const schema::ErrorInfo& error : schema::Errors())
      for (const char* suffix : {"", "_floor"}) {
        const std::string name = std::string(error.name) + suffix;
        // With a prefix, as an axis may have the same name.
        if (file_.Has("accuracy/" + name))
          AddNumber("error_" + name,
                    [&](const MeasuredPoint& point) { return model_.ErrorOf(point, name); });
      }
  }

  const figures::Model& model_;
  const results::ResultFile& file_;
  Table table_;
};

}  // namespace

Printed ResultsDocument(const results::ResultFile& file, const DocumentOptions& options) {
  const figures::Model model(file, {.only_sound = options.only_sound});
  CheckSize(model);
  const auto comparison = figures::CompareDetectors(model, options.baseline);
  const figures::Comparison* ratios = comparison ? &*comparison : nullptr;
  Json document = {{"document", kVersion}, {"generator", GeneratorOf(file)}};
  document["sources"] = Json::array(
      {{{"file", options.file}, {"benchmark", file.benchmark()}, {"title", file.title()}}});
  document["title"] = file.title();
  document["runs"] = DocumentRuns(model);
  document["warnings"] = DocumentWarnings(model);
  document["coverage"] = DocumentCoverage(model);
  document["conclusions"] = DocumentConclusions(model);
  document["axes"] = DocumentAxes(model);
  document["detector_axis"] = model.detector_axis() ? Json(*model.detector_axis()) : Json(nullptr);
  document["statistic"] = model.times().StatisticNote(false);
  document["interval"] = IntervalWords(model);
  document["method"] = MethodSentences(model);
  document["phases"] = DocumentPhases();
  document["points"] = DocumentPoints(model);
  document["ratios"] = DocumentRatios(model, ratios);
  document["fronts"] = DocumentFronts(model);
  document["budget"] = DocumentBudget(model);
  document["requirements"] = DocumentRequirements(model);
  document["boundaries"] = DocumentBoundaries(model);
  document["races"] = DocumentRaces(model);
  document["steady"] = DocumentSteady(model);
  if (options.for_page) {
    document["pooled"] = DocumentPooled(model, ratios);
    document["cycles"] = DocumentCycles(model);
    document["distributions"] = DocumentDistributions(model);
  }
  document["omissions"] = DocumentOmissions(model);
  document["findings"] = DocumentFindings(model);
  document["contact_findings"] = DocumentContacts(model);
  document["failures"] = DocumentFailures(
      model, options.for_page ? kMaxFailures : std::numeric_limits<std::size_t>::max());
  document["noise"] = DocumentNoise(model);
  document["machine"] = DocumentMachine(file);
  document["build"] = DocumentBuild(file);
  document["provenance"] = DocumentProvenance(file);
  // The text of damaged files may not be UTF-8.
  return {document.dump(-1, ' ', false, Json::error_handler_t::replace), model.bad_count(),
          figures::CountNotMet(model.requirements())};
}

Printed CsvText(const results::ResultFile& file, const CsvOptions& options) {
  const figures::Model model(file,
                             {.only_sound = options.only_sound, .statistic = options.statistic});
  return {CsvOf(PointTable(model, options.phases).table()), model.runs().bad.size(),
          figures::CountNotMet(model.requirements())};
}

// The head of a results document: runs, machine, noise, omissions, failures.

namespace {

using figures::Cell;

/// The names of a fact in the document and in /provenance.
using Fact = std::pair<const char*, const char*>;

Json FactsOf(const results::ResultFile& file, std::initializer_list<Fact> facts) {
  Json all = Json::object();
  for (const auto& [name, stored] : facts)
    if (std::string text = file.ReadProvenance(stored); !text.empty()) all[name] = std::move(text);
  return all;
}

/// The reason in a line `walls: left out: why` of the decisions of a run; empty if there is no such
/// line.
std::string ReasonIn(const std::string& decisions, std::string_view component) {
  const std::string line = std::string(component) + ": left out: ";
  for (auto at = decisions.find(line); at != std::string::npos; at = decisions.find(line, at + 1)) {
    if (at > 0 && decisions[at - 1] != '\n') continue;
    const auto begin = at + line.size();
    return decisions.substr(begin, decisions.find('\n', begin) - begin);
  }
  return {};
}

/// Above this, not every whole number is representable as a double.
constexpr double kMaxWhole = 9007199254740992.0;

double Rounded(double value, int digits) {
  char text[64];
  const auto end =
      std::to_chars(text, text + sizeof(text), value, std::chars_format::scientific, digits - 1)
          .ptr;
  double rounded = value;
  std::from_chars(text, end, rounded);
  return rounded;
}

}  // namespace

Json DocumentRuns(const figures::Model& model) {
  const figures::CellGroups& groups = model.runs();
  std::size_t failed = 0;
  for (const figures::CellGroups::Bad& bad : groups.bad)
    failed += model.file().ReadStatus(bad.cell) == results::Status::kDone ? 0 : 1;
  return {{"all", groups.NotSkipped() + groups.skipped},
          {"good", groups.good.size()},
          {"void", groups.bad.size() - failed},
          {"failed", failed},
          {"skipped", groups.skipped},
          {"missing", groups.missing},
          {"repeats", model.file().repeats()},
          {"cycles", model.file().cycles()}};
}

Json DocumentOmissions(const figures::Model& model) {
  const results::ResultFile& file = model.file();
  Json all = Json::array();
  if (!file.Has("omitted") || !file.Has("needs")) return all;
  for (const schema::ComponentInfo& info : schema::Components()) {
    if (!info.IsVisible()) continue;
    std::map<std::string, std::vector<std::size_t>> by_reason;
    for (const figures::MeasuredPoint& point : model.points())
      if (std::ranges::find(point.left_out, info.name) != point.left_out.end())
        by_reason[ReasonIn(file.ReadText("needs", point.cells[0]), info.name)].push_back(
            model.IndexOf(point.at));
    for (auto& [why, points] : by_reason)
      all.push_back({{"parts", info.name},
                     {"points", points.size()},
                     {"of", model.grid().size()},
                     {"why", why},
                     {"changes", info.changes},
                     {"at", IsLarge(model) ? Json(nullptr) : Json(points)}});
  }
  return all;
}

Json DocumentFindings(const figures::Model& model) {
  Json all = Json::array();
  for (const figures::DetectorFindings& of : model.findings())
    if (of.cycles > 0)
      all.push_back({{"detector", of.detector},
                     {"runs", of.runs},
                     {"cycles", of.cycles},
                     {"exact", of.exact},
                     {"missed", of.missed},
                     {"false_positives", of.false_positives},
                     {"duplicate", of.duplicate},
                     {"missed_contacts", of.missed_contacts},
                     {"wrong_runs", of.wrong_runs}});
  return all;
}

Json DocumentContacts(const figures::Model& model) {
  Json all = Json::array();
  for (const figures::ContactFindings& of : figures::ContactFindingsOf(model.file()))
    if (of.All() > 0)
      all.push_back({{"narrow_phase", of.narrow_phase},
                     {"runs", of.runs},
                     {"cycles", of.cycles},
                     {"compared", of.exact},
                     {"of", of.All()},
                     {"missed", of.missed}});
  return all;
}

Json DocumentFailures(const figures::Model& model, std::size_t most) {
  Json all = Json::array();
  for (const figures::CellGroups::Bad& bad : model.runs().bad) {
    if (all.size() == most) break;
    all.push_back({{"place", figures::PlaceText(model.file(), bad.cell)},
                   {"why", bad.why},
                   {"command", figures::OnlyCommand(model.file(), bad.cell)}});
  }
  return all;
}

Json DocumentNoise(const figures::Model& model) {
  const results::ResultFile& file = model.file();
  const std::vector<Cell>& cells = model.runs().good;
  std::size_t quiet = 0, noisy = 0;
  double least = figures::kNone, most = figures::kNone;
  for (const Cell& cell : cells) {
    if (file.Has("noise")) {
      const auto noise = static_cast<machine::Noise>(file.ReadReal("noise", cell));
      quiet += noise == machine::Noise::kQuiet ? 1 : 0;
      noisy += noise == machine::Noise::kNoisy ? 1 : 0;
    }
    if (!file.Has("load_average")) continue;
    least = std::fmin(least, file.ReadReal("load_average", cell));
    most = std::fmax(most, file.ReadReal("load_average", cell));
  }
  Json text = Json::array();
  for (const std::string& note : {NoiseNote(file, cells), HarnessNote(model)})
    if (!note.empty()) text.push_back(note);
  return {{"judgement", noisy > 0                            ? "noisy"
                        : quiet > 0 && quiet == cells.size() ? "quiet"
                                                             : "unknown"},
          {"noisy", noisy},
          {"text", std::move(text)},
          {"load", JsonNumbers({least, most})}};
}

Json DocumentMachine(const results::ResultFile& file) {
  return FactsOf(file, {{"host", "host"},
                        {"cpu", "cpu"},
                        {"cores", "cpus"},
                        {"memory", "memory"},
                        {"base_clock", "cpu_base_clock"},
                        {"maximum_clock", "cpu_max_clock"},
                        {"governor", "cpu_governor"},
                        {"system", "system"},
                        {"kernel", "kernel"}});
}

Json DocumentBuild(const results::ResultFile& file) {
  return FactsOf(file, {{"cdb", "cdb_version"},
                        {"commit", "commit"},
                        {"type", "build_type"},
                        {"compiler", "compiler"},
                        {"flags", "compiler_flags"},
                        {"bullet", "bullet_version"},
                        {"precision", "precision"}});
}

Json DocumentProvenance(const results::ResultFile& file) {
  Json all = {{"source", file.source()},
              {"benchmark", file.benchmark()},
              {"plan_sha256", file.plan_sha256()}};
  all.update(FactsOf(file, {{"jobs", "jobs"},
                            {"plugins", "plugins"},
                            {"settings", "settings"},
                            {"models", "models"},
                            {"detector_libraries", "detector_libraries"},
                            {"scenario", "scenario_text"}}));
  return all;
}

Json JsonNumber(double value, int digits) {
  if (!std::isfinite(value)) return nullptr;
  const double rounded = Rounded(value, digits);
  if (rounded == std::trunc(rounded) && std::fabs(rounded) < kMaxWhole)
    return static_cast<std::int64_t>(rounded);
  return rounded;
}

Json JsonNumbers(const std::vector<double>& values, int digits) {
  return JsonColumn(values.size(), [&](std::size_t i) { return JsonNumber(values[i], digits); });
}

Json FoldColumns(Json columns) {
  if (columns.is_array()) {
    for (const Json& value : columns)
      if (value != columns[0]) return columns;
    return columns.empty() ? columns : Json{{"constant", columns[0]}};
  }
  if (columns.is_object())
    for (auto& [key, column] : columns.items()) column = FoldColumns(std::move(column));
  return columns;
}

// Warnings to read before quoting a figure, for results documents.

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
    AddUnknownErrors();
    AddSleepers();
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
    for (const std::string& text : figures::ReferenceTexts(model_)) Add("failed", text);
  }

  void AddVerdicts() {
    std::vector<std::string> texts;
    std::size_t unsound = 0;
    for (auto row = groups_.verdicts.rbegin(); row != groups_.verdicts.rend(); ++row)
      if (row->first > protocol::Verdict::kStable) {
        unsound += row->second.size();
        texts.push_back(
            fmt::format("{} {}", row->second.size(), protocol::VerdictName(row->first)));
      }
    if (unsound > 0)
      Add("unsound",
          fmt::format("The simulation was unsound in {} ({}): their times are shown, but "
                      "are those of another motion.",
                      RunsText(unsound, groups_.good.size()), fmt::join(texts, ", ")));
  }

  /// Points that have a time, and no error.
  void AddUnknownErrors() {
    std::map<std::string, std::pair<std::string, std::size_t>> by_reason;
    for (const auto& [error, figures] : figures::CollectAllErrors(model_))
      for (const auto& [first, count] : figures::ByReason(figures.left_out)) {
        if (model_.Find(first->at) == nullptr) continue;
        auto& [names, most] = by_reason[first->why];
        names += fmt::format("{}{}", names.empty() ? "" : ", ", error->name);
        most = std::max(most, count);
      }
    for (const auto& [why, of] : by_reason)
      Add("no_error", fmt::format("{} of {} points have no error of {}: {}.", of.second,
                                  model_.grid().size(), of.first, why));
  }

  void AddSleepers() {
    const std::string note = figures::SleepNote(file_, groups_.good);
    if (!note.empty()) Add("asleep", note);
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
