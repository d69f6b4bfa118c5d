#include "runtime/figures/conclusions.h"

namespace cdb::figures {
namespace {

constexpr std::string_view kCertaintyNames[] = {"clear", "tie", "unknown"};

}  // namespace

std::string_view CertaintyName(Certainty certainty) {
  return kCertaintyNames[static_cast<std::size_t>(certainty)];
}

std::vector<Conclusion> Conclusions(const Model& model) {
  std::vector<Conclusion> all;
  ConcludeErrors(model, all);
  ConcludeStep(model, all);
  ConcludeDetectors(model, all);
  ConcludeVerdicts(model, all);
  ConcludeAxes(model, all);
  ConcludeDetectorLimits(model, all);
  return all;
}

}  // namespace cdb::figures
