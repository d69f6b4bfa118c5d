#include "runtime/schedule/held_against.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "compiler/reference.h"
#include "dsl/check.h"
#include "library/closed_forms/closed_form.h"
#include "runtime/accuracy/errors.h"

namespace cdb::runtime {
namespace {

/// A reference and its twin, for runs that take turns between two of them.
constexpr std::size_t kKept = 4;

RunErrors AgainstForm(const compiler::Run& run, const Samples& samples) {
  const library::InitialState state = library::MakeInitialState(run.scene);
  const auto form =
      library::MakeClosedForm(run.scene.world.WordOr("accuracy.closed_form"), run.scene, state);
  return CollectErrors(run.scene, samples, StandardOf(*form, samples).get(), nullptr, nullptr);
}

void Append(std::string& to, const std::string& text) { to += (to.empty() ? "" : "; ") + text; }

}  // namespace

HeldAgainst::HeldAgainst(const compiler::Plan& plan, std::filesystem::path folder)
    : plan_(plan), plan_sha256_(plan.Sha256()), folder_(std::move(folder)) {
  for (const compiler::Run& run : plan.references) references_.emplace(run.id, &run);
}

const ReferenceShard& HeldAgainst::Find(const std::string& id) {
  const auto kept = std::ranges::find(kept_, id, [](const auto& one) { return one.first; });
  if (kept != kept_.end()) {
    kept_.splice(kept_.begin(), kept_, kept);
    return kept_.front().second;
  }
  const compiler::Run& run = *references_.at(id);
  kept_.emplace_front(id, ReadReference(plan_sha256_, run, folder_ / (id + ".h5")));
  if (kept_.size() > kKept) kept_.pop_back();
  return kept_.front().second;
}

RunErrors HeldAgainst::ErrorsOf(const compiler::Run& run, Status status,
                                const Recording& recording) {
  RunErrors errors;
  const std::string_view form = run.scene.world.WordOr("accuracy.closed_form");
  const std::string truth = form != "none" ? std::string(form) : run.reference;
  if (status != Status::kDone) {
    errors.message = "the run did not end well";
    errors.truth = truth;
    return errors;
  }
  const auto sampling = compiler::SamplingOf(run.scene);
  CDB_CHECK(sampling);
  const Samples samples{*SampleShapeOf(run.scene), sampling->interval_s, recording.SampleValues()};
  try {
    if (form != "none") {
      errors = AgainstForm(run, samples);
    } else if (!run.reference.empty()) {
      errors = AgainstReference(run, samples);
    } else {
      errors = CollectErrors(run.scene, samples, nullptr, nullptr, nullptr);
    }
  } catch (const std::exception& error) {
    Append(errors.message, error.what());
  }
  errors.truth = truth;
  return errors;
}

RunErrors HeldAgainst::AgainstReference(const compiler::Run& run, const Samples& samples) {
  std::string trouble;
  const auto find = [&](const std::string& id) -> std::optional<Samples> {
    try {
      const ReferenceShard& shard = Find(id);
      const std::string name = Describe(plan_, *references_.at(id));
      Samples found{shard.shape, samples.interval_s, shard.values};
      if (shard.status != Status::kDone) {
        Append(trouble, fmt::format("{}: {}: {}", name, StatusName(shard.status), shard.message));
      } else if (!found.IsFinite()) {
        Append(trouble, fmt::format("{}: a state is not a number", name));
      } else if (found.shape != samples.shape) {
        Append(trouble, fmt::format("{}: has other samples than the run", name));
      } else {
        return found;
      }
    } catch (const StoreError& error) {
      Append(trouble, error.what());
    }
    return std::nullopt;
  };
  const auto reference = find(run.reference);
  const auto twin = find(run.twin);
  RunErrors errors;
  if (reference && twin) {
    const auto standard = StandardOf(*reference);
    errors = CollectErrors(run.scene, samples, standard.get(), &*reference, &*twin);
  } else {
    errors = CollectErrors(run.scene, samples, nullptr, nullptr, nullptr);
    Append(errors.message, trouble);
  }
  return errors;
}

}  // namespace cdb::runtime
