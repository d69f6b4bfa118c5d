#include "runtime/store/shards/shard_template.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>
#include <utility>
#include <variant>

namespace cdb::shards {
namespace {

std::string HistoryOf(const plan::Run& run) { return fmt::format("run {}", run.id); }

/// `rows`: number of rows of contacts.
ShardTemplate MakeTemplate(const plan::Plan& plan, const store::PlanFacts& facts,
                           const plan::Run& run, const store::Provenance& provenance,
                           std::uint64_t rows) {
  ShardTemplate made{store::MakeLayout(plan, facts, &run, rows), {}};
  hdf5::File file = hdf5::File::CreateInMemory(store::MembersOf(made.layout, ""));
  store::CreateSmallArrays(file, made.layout);
  store::WriteHead(file, plan, facts, HistoryOf(run));
  file.SetText("run_id", run.id);
  hdf5::Group group = file.CreateGroup("provenance");
  for (const auto& [name, text] : provenance) group.SetText(name.c_str(), text);
  group.CreateDataset({"run_text", hdf5::Type::kText, {}, {}, 0, /*is_small=*/true});
  made.image = file.Image();
  return made;
}

}  // namespace

std::shared_ptr<const ShardTemplate> ShardTemplates::Get(const plan::Run& run,
                                                         std::uint64_t rows) const {
  constexpr std::size_t kMost = 100;
  const std::lock_guard lock(mutex_);
  if (const auto found = templates_.find(rows); found != templates_.end()) return found->second;
  if (templates_.size() >= kMost) templates_.clear();
  return templates_[rows] = std::make_shared<const ShardTemplate>(
             MakeTemplate(plan_, facts_, run, provenance_, rows));
}

store::HeadTexts HeadOfRun(const plan::Run& run) {
  store::HeadTexts texts = store::DatedHead(HistoryOf(run));
  texts.emplace_back("run_id", run.id);
  return texts;
}

std::vector<RunCoordinate> RunCoordinates(const plan::Plan& plan, const store::PlanFacts& facts) {
  std::vector<std::string> groups = {"", std::string(store::kRunGroup)};
  if (facts.samples > 0) groups.emplace_back(store::kAccuracyGroup);
  std::vector<RunCoordinate> coordinates;
  for (const std::string& group : groups) {
    for (const plan::Axis& axis : plan.axes) coordinates.push_back({group + axis.name, &axis});
    coordinates.push_back({group + "rep", nullptr});
  }
  return coordinates;
}

plan::Coordinate ValueOf(const RunCoordinate& coordinate, const plan::Plan& plan,
                         const plan::Run& run) {
  if (coordinate.axis == nullptr) return static_cast<double>(run.rep);
  const auto axis = static_cast<std::size_t>(coordinate.axis - plan.axes.data());
  return coordinate.axis->values[run.at[axis]];
}

std::vector<const store::Dimension*> Labels(const store::Layout& layout,
                                            std::span<const RunCoordinate> coordinates) {
  std::vector<const store::Dimension*> labels;
  for (const store::Dimension& dimension : layout.dimensions)
    if (dimension.type == hdf5::Type::kText &&
        std::ranges::find(coordinates, dimension.name, &RunCoordinate::dataset) ==
            coordinates.end())
      labels.push_back(&dimension);
  return labels;
}

void WriteHeadOfRun(hdf5::File& file, const plan::Run& run) {
  for (const auto& [name, text] : HeadOfRun(run)) file.ReplaceText(name, text);
}

void WriteCoordinates(hdf5::File& file, const plan::Plan& plan, const store::PlanFacts& facts,
                      const store::Layout& layout, const plan::Run& run) {
  const std::vector<RunCoordinate> coordinates = RunCoordinates(plan, facts);
  for (const RunCoordinate& coordinate : coordinates) {
    hdf5::Dataset dataset = file.OpenDataset(coordinate.dataset);
    const plan::Coordinate value = ValueOf(coordinate, plan, run);
    if (const auto* text = std::get_if<std::string>(&value))
      dataset.WriteText({{*text}});
    else
      dataset.Write({{std::get<double>(value)}});
  }
  for (const store::Dimension* labels : Labels(layout, coordinates))
    file.OpenDataset(labels->name).WriteText(labels->texts);
}

}  // namespace cdb::shards
