#include "runtime/engine/harness.h"

#include <algorithm>
#include <array>
#include <vector>

#include "runtime/engine/detectors.h"

namespace cdb::runtime {

double HarnessNs(const compiler::Scene& scene, const Engine& engine) {
  const NamedDetector idle = MakeDetector("null", scene);
  Scene bodies = {};
  bodies.size = engine.objects().size() + engine.walls().size();
  std::vector<Pair> pairs;
  std::vector<Contact> contacts;
  std::array<std::int64_t, TimedWorld::kStamps> stamps = {};
  std::array<double, 101> times;
  for (double& time : times) {
    const std::int64_t begin = Now();
    for (std::int64_t& stamp : stamps) stamp = Now();
    idle.detector->FindPairs(bodies, pairs);
    idle.detector->FindContacts(bodies, pairs, contacts);
    time = static_cast<double>(Now() - begin);
  }
  std::ranges::nth_element(times, times.begin() + times.size() / 2);
  return times[times.size() / 2];
}

}  // namespace cdb::runtime
