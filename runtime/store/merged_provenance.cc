#include "runtime/store/merged_provenance.h"

#include <algorithm>

#include "runtime/store/dimensions.h"

namespace cdb::store {
namespace {

constexpr const char* kRuns = "run";

/// The dimension of the arrays. Not the axes of the grid, which may be called like a fact.
void WriteRuns(hdf5::Group& group, const std::vector<std::string>& ids) {
  hdf5::Dataset runs = group.CreateDataset({kRuns, hdf5::Type::kText, {ids.size()}, {}, 0});
  runs.WriteText(ids);
  runs.MakeScale(kRuns);
  runs.SetText("long_name", "id of a run: run_id of /run");
}

}  // namespace

void MergedProvenance::Add(const std::string& run_id,
                           const std::map<std::string, std::string>& facts) {
  ids_.push_back(run_id);
  for (const auto& [name, text] : facts) facts_[name];
  for (auto& [name, texts] : facts_) {
    texts.resize(ids_.size());
    if (const auto found = facts.find(name); found != facts.end()) texts.back() = found->second;
  }
}

hdf5::Group MergedProvenance::Write(hdf5::File& file, const Provenance& of_merging) const {
  hdf5::Group group = file.CreateGroup("provenance");
  for (const auto& [name, text] : of_merging)
    if (!facts_.contains(name)) group.SetText(name.c_str(), text);
  std::vector<hdf5::Group::Attachment> attachments;
  for (const auto& [name, texts] : facts_) {
    if (std::ranges::adjacent_find(texts, std::ranges::not_equal_to()) == texts.end()) {
      group.SetText(name.c_str(), texts.front());
      continue;
    }
    if (attachments.empty()) WriteRuns(group, ids_);
    hdf5::Dataset dataset = group.CreateDataset({name, hdf5::Type::kText, {ids_.size()}, {}, 0});
    dataset.WriteText(texts);
    dataset.SetText("long_name", "differs between the runs of this file");
    attachments.push_back({name, {kRuns}});
  }
  group.AttachScales(attachments);
  return group;
}

}  // namespace cdb::store
