#include "compiler/analysis/requested_errors.h"

#include <algorithm>
#include <set>
#include <string>

namespace cdb::analysis {
namespace {

using schema::ErrorInfo;
using schema::WordList;

/// Most runs of most plans request no errors, and a plan can have many runs.
bool AsksForNone(const WordList& metrics) { return metrics.size() == 1 && metrics[0] == "none"; }

const WordList& MetricsOf(const plan::Scene& scene) {
  return scene.world.Words("accuracy.metrics");
}

template <typename Words>
std::vector<const ErrorInfo*> ErrorsNamed(const Words& words) {
  std::vector<const ErrorInfo*> errors;
  for (const ErrorInfo& error : schema::Errors())
    if (std::ranges::find(words, error.metric) != words.end()) errors.push_back(&error);
  return errors;
}

}  // namespace

std::vector<const ErrorInfo*> ErrorsOf(const plan::Scene& scene) {
  const WordList& metrics = MetricsOf(scene);
  return AsksForNone(metrics) ? std::vector<const ErrorInfo*>() : ErrorsNamed(metrics);
}

std::vector<const ErrorInfo*> ErrorsOf(const plan::Plan& plan) {
  std::set<std::string, std::less<>> words;
  for (const plan::Run& run : plan.Bounds())
    if (const WordList& metrics = MetricsOf(run.scene); !AsksForNone(metrics))
      words.insert(metrics.begin(), metrics.end());
  return ErrorsNamed(words);
}

}  // namespace cdb::analysis
