#include "runtime/sweep/schedule/error_evaluator.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <utility>

#include "compiler/analysis/reference.h"
#include "dsl/text/check.h"
#include "library/closed_forms/closed_form.h"
#include "runtime/sweep/accuracy/errors.h"

namespace cdb::schedule {
namespace {

/// A reference and its twin, for runs that alternate between two references.
constexpr std::size_t kKept = 4;

protocol::RunErrors AgainstForm(const plan::Run& run, const protocol::Samples& samples) {
  const layouts::InitialState state = layouts::MakeInitialState(run.scene);
  const auto form = closed_forms::MakeClosedForm(run.scene.world.WordOr("accuracy.closed_form"),
                                                 run.scene, state);
  return accuracy::CollectErrors(run.scene, samples, accuracy::StandardOf(*form, samples).get(),
                                 nullptr, nullptr);
}

void Append(std::string& to, const std::string& text) { to += (to.empty() ? "" : "; ") + text; }

}  // namespace

ErrorEvaluator::ErrorEvaluator(const plan::Plan& plan, ReadRecord read)
    : plan_(plan), read_(std::move(read)) {
  for (const plan::Run& run : plan.references) references_.emplace(run.id, &run);
}

const journal::Reference& ErrorEvaluator::Find(const std::string& id) {
  const auto kept = std::ranges::find(kept_, id, [](const auto& one) { return one.first; });
  if (kept != kept_.end()) {
    kept_.splice(kept_.begin(), kept_, kept);
    return kept_.front().second;
  }
  const plan::Run& run = *references_.at(id);
  kept_.emplace_front(id, journal::ReadReference(run, read_(id)));
  if (kept_.size() > kKept) kept_.pop_back();
  return kept_.front().second;
}

protocol::RunErrors ErrorEvaluator::ErrorsOf(const plan::Run& run, results::Status status,
                                             const protocol::Recording& recording) {
  protocol::RunErrors errors;
  const std::string_view form = run.scene.world.WordOr("accuracy.closed_form");
  const std::string truth = form != "none" ? std::string(form) : run.reference;
  if (status != results::Status::kDone) {
    errors.message = "the run did not end well";
    errors.truth = truth;
    return errors;
  }
  const auto sampling = analysis::SamplingOf(run.scene);
  CDB_CHECK(sampling);
  const protocol::Samples samples{*protocol::SampleShapeOf(run.scene), sampling->interval_s,
                                  recording.SampleValues()};
  try {
    if (form != "none") {
      errors = AgainstForm(run, samples);
    } else if (!run.reference.empty()) {
      errors = AgainstReference(run, samples);
    } else {
      errors = accuracy::CollectErrors(run.scene, samples, nullptr, nullptr, nullptr);
    }
  } catch (const std::exception& error) {
    Append(errors.message, error.what());
  }
  errors.truth = truth;
  return errors;
}

protocol::RunErrors ErrorEvaluator::AgainstReference(const plan::Run& run,
                                                     const protocol::Samples& samples) {
  std::string trouble;
  const auto find = [&](const std::string& id) -> std::optional<protocol::Samples> {
    try {
      const journal::Reference& there = Find(id);
      const std::string name = Describe(plan_, *references_.at(id));
      protocol::Samples found{there.shape, samples.interval_s, there.values};
      if (there.status != results::Status::kDone) {
        Append(trouble,
               fmt::format("{}: {}: {}", name, results::StatusName(there.status), there.message));
      } else if (!found.IsFinite()) {
        Append(trouble, fmt::format("{}: a state is not finite", name));
      } else if (found.shape != samples.shape) {
        Append(trouble, fmt::format("{}: its samples differ from those of the run", name));
      } else {
        return found;
      }
    } catch (const std::runtime_error& error) {
      Append(trouble, error.what());
    }
    return std::nullopt;
  };
  const auto reference = find(run.reference);
  const auto twin = find(run.twin);
  protocol::RunErrors errors;
  if (reference && twin) {
    const auto standard = accuracy::StandardOf(*reference);
    errors = accuracy::CollectErrors(run.scene, samples, standard.get(), &*reference, &*twin);
  } else {
    errors = accuracy::CollectErrors(run.scene, samples, nullptr, nullptr, nullptr);
    Append(errors.message, trouble);
  }
  return errors;
}

}  // namespace cdb::schedule
