#include "runtime/sweep/schedule/shared_omissions.h"

#include "compiler/analysis/pruning.h"
#include "compiler/schema/components.h"

namespace cdb::schedule {
namespace {

using schema::ComponentInfo;

std::uint32_t BitOf(const ComponentInfo& info) {
  return 1u << static_cast<unsigned>(info.component);
}

std::string NamesOf(std::uint32_t components) {
  std::string names;
  for (const ComponentInfo& info : schema::Components())
    if ((components & BitOf(info)) != 0) names.append(names.empty() ? "" : " ").append(info.name);
  return names;
}

/// A key that is the same for runs that are compared.
std::string GroupOf(const plan::Run& run) {
  plan::Scene scene = run.scene;
  scene.world.Set("detector", schema::Word{"simple"});
  scene.world.Set("narrow_phase", schema::Word{"bullet"});
  scene.world.Set("pair_order", schema::Word{"sorted"});
  scene.world.Set("threads", std::uint64_t{1});
  scene.world.Set("seed", std::uint64_t{0});
  for (auto& [stream, seed] : scene.seeds) seed = 0;
  scene.plugins.clear();
  return plan::RunId(scene, 0);
}

}  // namespace

void SharedOmissions::Note(const plan::Run& run, std::string_view omitted,
                           std::string_view decisions) {
  Components left_out = 0, kept = 0;
  for (const ComponentInfo& info : schema::Components()) {
    if (!info.IsVisible() ||
        analysis::RequestFor(run.scene, info.component) != analysis::PruningRequest::kAuto)
      continue;
    if (schema::ListsWord(omitted, info.name)) left_out |= BitOf(info);
    if (analysis::SaysKept(decisions, info.component)) kept |= BitOf(info);
  }
  omitted_[run.id] = left_out;
  if (kept != 0) kept_[GroupOf(run)] |= kept;
}

SharedOmissions::Components SharedOmissions::KeptInGroupOf(const plan::Run& run) const {
  if (kept_.empty()) return 0;
  const auto found = kept_.find(GroupOf(run));
  return found == kept_.end() ? 0 : found->second;
}

std::string SharedOmissions::KeptFor(const plan::Run& run) const {
  return NamesOf(KeptInGroupOf(run));
}

std::string SharedOmissions::MissingIn(const plan::Run& run) const {
  const auto found = omitted_.find(run.id);
  if (found == omitted_.end() || found->second == 0) return {};
  return NamesOf(found->second & KeptInGroupOf(run));
}

}  // namespace cdb::schedule
