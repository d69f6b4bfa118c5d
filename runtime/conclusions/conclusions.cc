#include "runtime/conclusions/conclusions.h"

namespace cdb::conclusions {
namespace {

constexpr std::string_view kCertaintyNames[] = {"clear", "tie", "unknown"};

}  // namespace

std::string_view CertaintyName(Certainty certainty) {
  return kCertaintyNames[static_cast<std::size_t>(certainty)];
}

std::vector<Conclusion> Conclusions(const ConclusionParts& parts) {
  std::vector<Conclusion> all;
  ConcludeErrors(parts, all);
  ConcludeStep(parts, all);
  ConcludeDetectors(parts, all);
  ConcludeVerdicts(parts, all);
  ConcludeAxes(parts, all);
  ConcludeDetectorLimits(parts, all);
  return all;
}

}  // namespace cdb::conclusions
