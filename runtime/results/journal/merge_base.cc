#include "runtime/results/journal/merge_base.h"

#include <fmt/format.h>

#include <string_view>
#include <utility>

#include "runtime/results/files/seal.h"
#include "runtime/results/store.h"
#include "runtime/results/versions.h"

namespace cdb::journal {

MergeBase::MergeBase(const std::filesystem::path& path, const results::PlanFacts& facts, Of of)
    : file_(hdf5::File::Open(path)) {
  if (files::CheckSeal(path) == files::SealState::kBroken)
    throw files::StoreError(
        fmt::format("{}: is damaged, and nothing was taken from it; nothing was changed: "
                    "--fresh runs all again",
                    path.string()));
  if (of == Of::kSamePlan && file_.Text("plan_sha256") != facts.sha256)
    throw files::StoreError(
        fmt::format("{}: holds the results of another plan; nothing was changed", path.string()));
  if (const int version = results::ReadVersion(file_, path.string());
      version != results::kSchemaVersion)
    throw files::StoreError(
        fmt::format("{}: is of schema version {}, but runs can be replaced only in version {}; "
                    "nothing was changed: use --fresh to execute every run",
                    path.string(), version, results::kSchemaVersion));
  for (const results::RunNumber& number : facts.numbers) {
    if (file_.Has(number.name)) {
      numbers_.push_back(file_.OpenDataset(number.name).Read());
    } else {  // an earlier build did not measure it; the first of them, the status, always exists
      numbers_.emplace_back(numbers_.at(0).size(), number.missing);
    }
  }
  for (const results::RunText& text : facts.texts) {
    if (file_.Has(text.name))
      texts_.push_back(file_.OpenDataset(text.name).ReadText());
    else
      texts_.emplace_back(numbers_.at(0).size());
  }
  if (facts.contacts && file_.Has("contact_first")) {
    contact_first_ = file_.OpenDataset("contact_first").Read();
    contact_rows_ = file_.OpenDataset("contact_distance").shape().at(0);
  }
  ReadProvenance();
}

void MergeBase::ReadProvenance() {
  const hdf5::Group group = file_.OpenGroup("provenance");
  shared_ = group.Texts();
  if (!group.Has(std::string(results::kProvenanceRuns))) return;
  const std::vector<std::string> ids =
      group.OpenDataset(std::string(results::kProvenanceRuns)).ReadText();
  for (std::size_t i = 0; i < ids.size(); ++i) places_.emplace(ids[i], i);
  for (const std::string& name : group.MemberNames())
    if (name != results::kProvenanceRuns && name != "plan_text" && name != "scenario_text")
      varied_.emplace(name, group.OpenDataset(name).ReadText());
}

bool MergeBase::Has(std::size_t cell) const {
  const double status = numbers_.at(0).at(cell);  // the first of RunNumbers
  return status != static_cast<double>(results::Status::kMissing) &&
         status != static_cast<double>(results::Status::kSkipped);
}

std::map<std::string, std::string> MergeBase::ProvenanceOf(const std::string& run_id) const {
  std::map<std::string, std::string> facts = shared_;
  const auto place = places_.find(run_id);
  if (place == places_.end()) return facts;
  for (const auto& [name, texts] : varied_) facts[name] = texts.at(place->second);
  return facts;
}

std::optional<MergeBase::Rows> MergeBase::ContactRows(std::size_t cell) const {
  if (contact_first_.empty()) return std::nullopt;  // no run of its plan records them
  const double first = contact_first_.at(cell);
  if (!(first >= 0)) return std::nullopt;
  // The rows of cells follow one another, in grid order.
  double end = static_cast<double>(contact_rows_);
  for (std::size_t next = cell + 1; next < contact_first_.size(); ++next)
    if (contact_first_[next] >= 0) {
      end = contact_first_[next];
      break;
    }
  if (end < first || end > static_cast<double>(contact_rows_))
    throw hdf5::Error("contact_first does not fit the contacts");
  const auto begin = static_cast<std::uint64_t>(first);
  return Rows{begin, static_cast<std::uint64_t>(end) - begin};
}

}  // namespace cdb::journal
