#include "runtime/store/shards/shard_template.h"

#include <fmt/format.h>

#include <string>
#include <utility>
#include <variant>

#include "runtime/store/layout_file.h"

namespace cdb::shards {
namespace {

std::string HistoryOf(const plan::Run& run) { return fmt::format("run {}", run.id); }

/// `rows`: number of rows of contacts.
ShardTemplate MakeTemplate(const plan::Plan& plan, const store::PlanFacts& facts,
                           const plan::Run& run, const store::Provenance& provenance,
                           std::uint64_t rows) {
  ShardTemplate made{store::MakeLayout(plan, facts, &run, rows), {}};
  hdf5::File file = hdf5::File::CreateInMemory();
  store::WriteHead(file, plan, facts, HistoryOf(run));
  file.SetText("run_id", run.id);
  store::CreateArrays(file, made.layout);
  hdf5::Group group = file.CreateGroup("provenance");
  for (const auto& [name, text] : provenance) group.SetText(name.c_str(), text);
  hdf5::Dataset text = group.CreateDataset({"run_text", hdf5::Type::kText, {}, {}, 0});
  text.SetText("long_name", "all that decides the run, as YAML");
  made.image = file.Image();
  return made;
}

}  // namespace

std::shared_ptr<const ShardTemplate> ShardTemplates::Get(const plan::Run& run,
                                                         std::uint64_t rows) const {
  constexpr std::size_t kMost = 100;
  std::vector<std::size_t> key = {rows};
  for (std::size_t i = 0; i < plan_.axes.size(); ++i)
    if (plan_.axes[i].IsText()) key.push_back(run.at[i]);
  const std::lock_guard lock(mutex_);
  if (const auto found = templates_.find(key); found != templates_.end()) return found->second;
  if (templates_.size() >= kMost) templates_.clear();
  auto made =
      std::make_shared<const ShardTemplate>(MakeTemplate(plan_, facts_, run, provenance_, rows));
  return templates_[std::move(key)] = std::move(made);
}

void WriteHeadOfRun(hdf5::File& file, const plan::Run& run) {
  store::RenewHead(file, HistoryOf(run));
  file.ReplaceText("run_id", run.id);
}

void WritePlace(hdf5::File& file, const plan::Plan& plan, const store::PlanFacts& facts,
                const plan::Run& run) {
  WriteHeadOfRun(file, run);
  std::vector<std::string> groups = {"", std::string(store::kRunGroup)};
  if (facts.samples > 0) groups.emplace_back(store::kAccuracyGroup);
  for (const std::string& group : groups) {
    for (std::size_t i = 0; i < plan.axes.size(); ++i)
      if (!plan.axes[i].IsText())
        file.OpenDataset(group + plan.axes[i].name)
            .Write({{std::get<double>(plan.axes[i].values[run.at[i]])}});
    file.OpenDataset(group + "rep").Write({{static_cast<double>(run.rep)}});
  }
}

}  // namespace cdb::shards
