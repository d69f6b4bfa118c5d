// The head of a results document: runs, machine, noise, omissions, failures.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "compiler/schema/components.h"
#include "runtime/figures/bootstrap.h"
#include "runtime/printers/json_parts.h"
#include "runtime/printers/notes.h"

namespace cdb::printers {
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
                        {"bullet", "bullet_version"}});
}

Json DocumentProvenance(const results::ResultFile& file) {
  Json all = {{"source", file.source()},
              {"benchmark", file.benchmark()},
              {"plan_sha256", file.plan_sha256()}};
  all.update(FactsOf(file, {{"jobs", "jobs"},
                            {"plugins", "plugins"},
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

}  // namespace cdb::printers
