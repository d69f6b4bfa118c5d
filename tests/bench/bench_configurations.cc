// How many configurations of a spherised arm with seven joints are checked in a second, among 20
// fixed boxes: by lanes, in each kernel, and by Bullet's phases. The programs run in turn, in each
// round; medians of the rounds, with the least and the largest. Lanes: processor time, forward
// kinematics included. Detectors: the median `step` of a configuration, without forward kinematics.
// Usage: bench_configurations_f32 [ROUNDS]

#include <fmt/format.h>
#include <stdlib.h>
#include <time.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "library/robots/lanes.h"
#include "runtime/engine/worker/run_configurations.h"
#include "tests/bench/median.h"
#include "tests/library/robots/arm_scene.h"

namespace cdb::bench {
namespace {

constexpr int kOfLanes = 100'000, kOfDetectors = 2000;

/// s, of this thread, so that a busy machine does not count.
double Seconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Entry {
  std::string name;
  std::vector<double> rates;  ///< configurations per second, by round
  std::size_t hits = 0, all = 0, rechecked = 0;
};

void AddLanes(const plan::Scene& scene, const layouts::InitialState& state,
              const std::vector<double>& positions, const robots::LaneKernel& kernel,
              Entry& entry) {
  robots::LaneChecker checker(scene, state, &kernel);
  std::vector<std::uint8_t> hits(kOfLanes);
  const double begin = Seconds();
  checker.Check(positions, hits);
  entry.rates.push_back(kOfLanes / (Seconds() - begin));
  entry.hits = static_cast<std::size_t>(std::ranges::count(hits, 1));
  entry.all = hits.size();
  entry.rechecked = checker.rechecked();
}

void AddDetector(const plan::Scene& scene, Entry& entry) {
  plan::Run run;
  run.scene = scene;
  run.scene.world.Set("detector", schema::Word{entry.name});
  protocol::Recording recording = protocol::Recording::Create(run.scene);
  worker::RunConfigurations(run, recording, {});
  const auto steps =
      recording.Reals("duration").subspan(protocol::IndexOf(protocol::Phase::kStep) * kOfDetectors);
  entry.rates.push_back(1e9 /
                        Median(std::vector<double>(steps.begin(), steps.begin() + kOfDetectors)));
  const auto hits = recording.Ints("hit");
  entry.hits = static_cast<std::size_t>(std::ranges::count(hits, 1));
  entry.all = hits.size();
}

void Print(const Entry& entry) {
  const auto [least, most] = std::ranges::minmax(entry.rates);
  fmt::print("{:<12} {:>12.0f} {:>12.0f} {:>12.0f} {:>7.1f} % {:>9}\n", entry.name,
             Median(entry.rates), least, most,
             100 * static_cast<double>(entry.hits) / static_cast<double>(entry.all),
             entry.rechecked);
}

void Compare(const char* title, const std::string& settings, int rounds) {
  const auto scene_of = [&](int cycles) {
    return tests::SceneOfText(tests::BallArm(
        fmt::format("{}\n  cycles {}; precision {}", settings, cycles, world::EnginePrecision()),
        false, true));
  };
  const plan::Scene scene = scene_of(kOfLanes), of_detectors = scene_of(kOfDetectors);
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  const std::vector<double> positions = robots::PositionsOf(scene);
  std::vector<Entry> entries = {
      {"lanes plain", {}}, {"lanes avx2", {}}, {"dbvt", {}}, {"sap32", {}}};
  for (int round = 0; round < rounds; ++round)
    for (Entry& entry : entries) {
      if (entry.name == "lanes plain")
        AddLanes(scene, state, positions, robots::PlainLaneKernel(), entry);
      else if (entry.name != "lanes avx2")
        AddDetector(of_detectors, entry);
      else if (robots::Avx2LaneKernel() != nullptr)
        AddLanes(scene, state, positions, *robots::Avx2LaneKernel(), entry);
    }
  fmt::print("{}\n{:<12} {:>12} {:>12} {:>12} {:>9} {:>9}\n", title, "", "median/s", "least",
             "most", "hit", "rechecked");
  for (const Entry& entry : entries)
    if (!entry.rates.empty()) Print(entry);
}

}  // namespace
}  // namespace cdb::bench

int main(int argc, char** argv) {
  using namespace cdb::bench;
  const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 7;
  double load[1] = {0};
  if (getloadavg(load, 1) == 1) fmt::print("load average {:.1f}\n", load[0]);
  Compare("drawn, one after the other unlike", "", rounds);
  Compare("along a path",
          "configurations.positions path; joint0.goal 2; joint1.goal -1; joint3.goal 2", rounds);
  return 0;
}
