#include "runtime/results/merged_provenance.h"

#include <algorithm>

#include "runtime/results/dimensions.h"

namespace cdb::results {
namespace {

const std::string kRuns(kProvenanceRuns);

/// The dimension of the arrays. Axes of the grid are not used, because one may have the name of a
/// fact.
void WriteRuns(hdf5::Group& group, const std::vector<std::string>& ids) {
  hdf5::Dataset runs = group.CreateDataset({kRuns, hdf5::Type::kText, {ids.size()}, {}, 0});
  runs.WriteText(ids);
  runs.MakeScale(kRuns);
  runs.SetText("long_name", "id of a run: run_id of /run");
}

}  // namespace

void MergedProvenance::Add(const std::string& run_id,
                           const std::map<std::string, std::string>& facts) {
  for (const auto& [name, text] : facts) {
    Fact& fact = facts_[name];
    fact.by_run.resize(ids_.size(), 0);
    std::size_t place = fact.by_run.empty() ? 0 : fact.by_run.back();
    if (fact.texts[place] != text) {
      const auto [found, is_new] = fact.places.try_emplace(text, fact.texts.size());
      if (is_new) fact.texts.push_back(text);
      place = found->second;
    }
    fact.by_run.push_back(place);
  }
  ids_.push_back(run_id);
}

std::vector<std::string> MergedProvenance::TextsOf(const Fact& fact) const {
  std::vector<std::string> texts;
  for (const std::size_t place : fact.by_run) texts.push_back(fact.texts[place]);
  texts.resize(ids_.size());
  return texts;
}

hdf5::Group MergedProvenance::Write(hdf5::File& file, const Provenance& of_merging) const {
  hdf5::Group group = file.CreateGroup("provenance");
  for (const auto& [name, text] : of_merging)
    if (!facts_.contains(name)) group.SetText(name.c_str(), text);
  std::vector<hdf5::Group::Attachment> attachments;
  for (const auto& [name, fact] : facts_) {
    if (fact.by_run.size() == ids_.size() &&
        std::ranges::adjacent_find(fact.by_run, std::ranges::not_equal_to()) == fact.by_run.end()) {
      group.SetText(name.c_str(), fact.texts[fact.by_run.front()]);
      continue;
    }
    if (attachments.empty()) WriteRuns(group, ids_);
    hdf5::Dataset dataset = group.CreateDataset({name, hdf5::Type::kText, {ids_.size()}, {}, 0});
    dataset.WriteText(TextsOf(fact));
    dataset.SetText("long_name", "differs between the runs of this file");
    attachments.push_back({name, {kRuns}});
  }
  group.AttachScales(attachments);
  return group;
}

}  // namespace cdb::results
