#include "runtime/engine/worker/harness.h"

#include <algorithm>
#include <array>
#include <vector>

#include "runtime/engine/detection/detectors.h"

namespace cdb::worker {

double HarnessNs(const plan::Scene& scene, const world::Engine& engine) {
  const detection::NamedDetector idle = detection::MakeDetector("null", scene);
  Scene bodies = {};
  bodies.size = engine.objects().size() + engine.walls().size();
  std::vector<Pair> pairs;
  std::vector<Contact> contacts;
  std::array<std::int64_t, world::TimedWorld::kStamps> stamps = {};
  std::array<double, 101> times;
  for (double& time : times) {
    const std::int64_t begin = world::Now();
    for (std::int64_t& stamp : stamps) stamp = world::Now();
    idle.detector->FindPairs(bodies, pairs);
    idle.detector->FindContacts(bodies, pairs, contacts);
    time = static_cast<double>(world::Now() - begin);
  }
  std::ranges::nth_element(times, times.begin() + times.size() / 2);
  return times[times.size() / 2];
}

}  // namespace cdb::worker
