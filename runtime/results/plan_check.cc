#include "runtime/results/plan_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "compiler/yaml/plan_yaml.h"
#include "compiler/yaml/short_plan.h"
#include "runtime/results/layout.h"
#include "runtime/results/proof.h"
#include "runtime/results/run_facts.h"
#include "runtime/results/store.h"
#include "runtime/results/versions.h"

namespace cdb::results {
namespace {

/// Nullopt for a plan in the short form, which only a compiler can read, and for one that this
/// version does not read.
std::optional<plan::Plan> ReadListedPlan(const std::string& text) {
  try {
    if (yaml::FindShortPlan(text, "plan_text")) return std::nullopt;
    return yaml::FromYaml(text, "plan_text");
  } catch (const yaml::PlanError&) {
    return std::nullopt;
  }
}

void CheckCoordinates(const hdf5::File& file, const plan::Axis& axis) {
  const hdf5::Dataset dataset = file.OpenDataset(axis.name);
  std::vector<plan::Coordinate> values;
  if (dataset.type() == hdf5::Type::kText) {
    for (std::string& text : dataset.ReadText()) values.emplace_back(std::move(text));
  } else {
    for (const double value : dataset.Read()) values.emplace_back(value);
  }
  if (values != axis.values)
    throw hdf5::Error(fmt::format("the axis {} has other values than its plan", axis.name));
}

/// Earlier versions had fewer arrays.
void CheckIsAs(const hdf5::File& file, const std::string& name, hdf5::Type type,
               const hdf5::Shape& shape) {
  if (!file.Has(name)) return;
  const hdf5::Dataset dataset = file.OpenDataset(name);
  if (dataset.type() != type || dataset.shape() != shape)
    throw hdf5::Error(fmt::format("{} has another type or shape than its plan has", name));
}

std::uint64_t RowsOfContacts(const hdf5::File& file) {
  return file.Has("contact_row") ? hdf5::Product(file.OpenDataset("contact_row").shape()) : 0;
}

void CheckLayout(const hdf5::File& file, const FileExtents& extents, const plan::Plan& plan) {
  const PlanFacts facts(plan);
  const Layout layout = MakeLayout(plan, facts, RowsOfContacts(file));
  if (layout.grid != extents.grid || facts.cycles != extents.cycles)
    throw hdf5::Error("its axes are not as long as its plan has them");
  for (const Dimension& dimension : layout.dimensions)
    CheckIsAs(file, dimension.name, dimension.type, {dimension.size});
  for (const Array& array : layout.arrays) CheckIsAs(file, array.name, array.type, array.shape);
  const bool has_durations =
      std::ranges::find(layout.arrays, "duration", &Array::name) != layout.arrays.end();
  if (has_durations && !file.Has("duration"))
    throw hdf5::Error("it lacks the durations that its plan records");
}

void CheckRuns(const hdf5::File& file, const FileExtents& extents, const plan::Plan& plan) {
  const std::vector<double> statuses = file.OpenDataset("status").Read();
  const std::vector<std::string> ids =
      file.OpenDataset(PathIn(extents.version, "run/run_id")).ReadText();
  plan.ForEachRun([&](const std::string& id, const auto& at, std::uint64_t rep) {
    std::size_t cell = 0;
    for (std::size_t i = 0; i < at.size(); ++i) cell = cell * extents.grid[i] + at[i];
    cell = cell * extents.grid.back() + rep;
    if (statuses.at(cell) == static_cast<double>(Status::kSkipped))
      throw hdf5::Error(fmt::format("the run {} of its plan is marked as skipped", id));
    if (ids.at(cell) != id)
      throw hdf5::Error(fmt::format("it contains the run {} where its plan has {}", ids[cell], id));
  });
}

}  // namespace

void CheckAgainstPlan(const hdf5::File& file, const FileExtents& extents, const plan::Plan& plan) {
  if (plan.Sha256() != file.Text("plan_sha256"))
    throw hdf5::Error("its plan differs from its plan_sha256");
  if (extents.grid.size() != plan.axes.size() + 1 || extents.grid.back() != plan.repeats)
    throw hdf5::Error("its axes differ from those of its plan");
  if (extents.version == kSchemaVersion) CheckLayout(file, extents, plan);
  for (const plan::Axis& axis : plan.axes) CheckCoordinates(file, axis);
  CheckRuns(file, extents, plan);
}

void CheckAgainstPlan(const hdf5::File& file, const FileExtents& extents,
                      const std::string& plan_text) {
  // Earlier versions, which wrote no digest, had files without a plan.
  if (plan_text.empty() && !file.Text(kDigestAttribute).empty())
    throw hdf5::Error("it contains no plan");
  if (extents.version != kSchemaVersion) return;
  if (const auto plan = ReadListedPlan(plan_text)) CheckAgainstPlan(file, extents, *plan);
}

}  // namespace cdb::results
