// Configurations checked for collisions, for `cdb show` and `cdb verify`.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "runtime/printers/show.h"
#include "runtime/terminal/table.h"

namespace cdb::printers {
namespace {

using figures::Row;

/// The values of a cell; empty if the file does not have the series.
std::vector<double> ValuesOf(const figures::Model& model, const figures::MeasuredPoint& point,
                             const char* series) {
  return model.file().Has(series) ? model.file().ReadSeries(series, point.cells[0])
                                  : std::vector<double>();
}

std::size_t CountPositive(const std::vector<double>& values) {
  return static_cast<std::size_t>(
      std::ranges::count_if(values, [](double value) { return value > 0; }));
}

bool AreAsked(const std::vector<double>& values) {
  return std::ranges::any_of(values, [](double value) { return value >= 0; });
}

std::string ShareText(std::size_t part, std::size_t all) {
  return fmt::format("{:.3g} %", 100 * static_cast<double>(part) / static_cast<double>(all));
}

}  // namespace

ConfigurationFigures ConfigurationFiguresOf(const figures::Model& model,
                                            const std::vector<const figures::MeasuredPoint*>& of) {
  ConfigurationFigures sums;
  for (const figures::MeasuredPoint* point : of) {
    const std::vector<double> hit = ValuesOf(model, *point, "hit"),
                              exact = ValuesOf(model, *point, "exact_hit"),
                              self = ValuesOf(model, *point, "self_hits"),
                              scene = ValuesOf(model, *point, "scene_hits");
    for (std::size_t i = 0; i < hit.size(); ++i) {
      if (!(hit[i] >= 0)) continue;  // a run of another kind
      ++sums.all;
      sums.hit += hit[i] > 0;
      if (i >= exact.size() || !(exact[i] >= 0)) continue;
      ++sums.compared;
      sums.missed += exact[i] > 0 && hit[i] == 0;
      sums.wrong += exact[i] == 0 && hit[i] > 0;
    }
    sums.are_told_apart = sums.are_told_apart || AreAsked(self);
    sums.self += CountPositive(self);
    sums.scene += CountPositive(scene);
    for (const double error : ValuesOf(model, *point, "distance_error"))
      sums.distance_error = std::fmax(sums.distance_error, error);
  }
  return sums;
}

double ConfigurationsPerSecond(double step_ns) { return 1e9 / step_ns; }

void AddConfigurations(const figures::Model& model, const std::vector<std::size_t>& by,
                       Document& document) {
  if (model.points().empty() || !model.file().Has("hit")) return;
  const figures::Rows rows = figures::MatchRows(model.points(), by);
  const bool is_judged = model.file().Has("exact_hit"), has_times = model.HasTimes();
  const bool has_distances =
      std::ranges::any_of(model.points(), [&](const figures::MeasuredPoint& point) {
        return std::ranges::any_of(ValuesOf(model, point, "distance_error"),
                                   [](double error) { return error >= 0; });
      });
  RowTable table(model.file(), rows);
  table.AddColumn("configurations");
  if (has_times) table.AddColumn("per second");
  for (const char* head : {"hit", "self", "scene"}) table.AddColumn(head);
  if (is_judged)
    for (const char* head : {"compared", "missed", "false"}) table.AddColumn(head);
  if (is_judged && has_distances) table.AddColumn("distance error");
  bool is_empty = true;
  for (const Row& row : rows.rows) {
    const ConfigurationFigures sums = ConfigurationFiguresOf(model, row.points);
    if (sums.all == 0) continue;
    is_empty = false;
    std::vector<std::string> figures = {fmt::format("{}", sums.all)};
    if (has_times)
      figures.push_back(terminal::ShortNumber(
          ConfigurationsPerSecond(model.TimeOf(row, protocol::Phase::kStep).value)));
    figures.push_back(ShareText(sums.hit, sums.all));
    for (const std::size_t part : {sums.self, sums.scene})
      figures.push_back(sums.are_told_apart ? ShareText(part, sums.all) : "-");
    if (is_judged) {
      figures.push_back(fmt::format("{} of {}", sums.compared, sums.all));
      figures.push_back(fmt::format("{}", sums.missed));
      figures.push_back(fmt::format("{}", sums.wrong));
    }
    if (is_judged && has_distances) figures.push_back(terminal::ShortNumber(sums.distance_error));
    table.AddRow(row, figures, "");
  }
  if (is_empty) return;
  Section section = {.title = "Configurations checked for collisions", .table = table.Take()};
  section.notes.push_back(
      "hit: the robot hits itself or the scene. self, scene: which of these; both may be in one "
      "configuration.");
  if (is_judged)
    section.notes.push_back(
        "compared: configurations in which exact geometry is certain whether two bodies overlap; "
        "missed, false: hits that were not found, or found where nothing overlaps.");
  document.push_back(std::move(section));
}

}  // namespace cdb::printers
