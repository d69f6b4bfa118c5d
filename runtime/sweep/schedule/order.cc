#include "runtime/sweep/schedule/order.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "runtime/sweep/process/launcher.h"

namespace cdb::schedule {
namespace {

/// Runs that differ only in the detector.
struct DetectorGroup {
  std::string point;  ///< identifies the scene without its detector
  std::uint64_t rep = 0;
  double work = 0;
  std::vector<const plan::Run*> runs;
};

/// A key that is the same for two runs of one point.
std::string PointKey(const plan::Run& run) {
  plan::Scene scene = run.scene;
  scene.world.Erase("detector");
  scene.plugins.clear();
  return plan::RunId(scene, 0);
}

/// In grid order, with the repeats one after the other.
std::vector<DetectorGroup> GroupByDetector(const plan::Plan& plan) {
  std::vector<DetectorGroup> groups;
  std::unordered_set<std::string_view> seen;
  std::unordered_map<std::string, std::size_t> places;
  for (const plan::Run& run : plan.runs) {
    if (!seen.insert(run.id).second) continue;
    const std::string point = PointKey(run);
    const auto [place, is_new] =
        places.try_emplace(fmt::format("{} {}", point, run.rep), groups.size());
    if (is_new) groups.push_back({point, run.rep, 0, {}});
    groups[place->second].runs.push_back(&run);
    groups[place->second].work += EstimatedWork(run);
  }
  std::ranges::stable_sort(groups, {}, &DetectorGroup::rep);
  return groups;
}

/// Fisher and Yates, written out: std::shuffle differs between standard libraries, and every node
/// of a cluster must get the same order.
void Shuffle(std::vector<const plan::Run*>& runs, std::uint64_t seed) {
  for (std::size_t i = runs.size(); i > 1; --i) {
    seed = plan::StreamSeed(seed, "order");
    std::swap(runs[i - 1], runs[seed % i]);
  }
}

/// The shard of each group, from 1: the heaviest first, each to the shard with the least load so
/// far.
std::vector<std::uint64_t> ShardOfEach(const std::vector<DetectorGroup>& groups,
                                       std::uint64_t count) {
  std::vector<std::size_t> heaviest(groups.size());
  std::iota(heaviest.begin(), heaviest.end(), std::size_t{0});
  std::ranges::stable_sort(heaviest, std::greater<>{},
                           [&groups](std::size_t i) { return groups[i].work; });
  std::map<std::pair<double, std::uint64_t>, int> loads;  // a queue by load, then by index
  for (std::uint64_t i = 1; i <= std::min<std::uint64_t>(count, groups.size()); ++i)
    loads.emplace(std::pair{0.0, i}, 0);
  std::vector<std::uint64_t> shards(groups.size(), 1);
  for (const std::size_t i : heaviest) {
    const auto [load, index] = loads.begin()->first;
    loads.erase(loads.begin());
    loads.emplace(std::pair{load + groups[i].work, index}, 0);
    shards[i] = index;
  }
  return shards;
}

}  // namespace

std::vector<const plan::Run*> ReferencesOf(const plan::Plan& plan,
                                           const std::vector<const plan::Run*>& runs) {
  std::unordered_set<std::string_view> wanted;
  for (const plan::Run* run : runs) wanted.insert({run->reference, run->perturbed});
  std::vector<const plan::Run*> references;
  for (const plan::Run& reference : plan.references)
    if (wanted.contains(reference.id)) references.push_back(&reference);
  return references;
}

double EstimatedWork(const plan::Run& run) {
  const plan::WorldSettings& world = run.scene.world;
  const auto cycles = static_cast<double>(world.Count("cycles") + world.Count("warmup"));
  const auto objects = static_cast<double>(run.scene.ObjectCount());
  // A cycle of an empty world costs about as much as ten objects; a process and its record cost
  // about as much as ten thousand objects for one cycle.
  return 10'000 + cycles * (10 + objects);
}

void CheckShard(ShardChoice shard) {
  if (shard.index < 1 || shard.index > shard.count)
    throw process::ScheduleError(
        fmt::format("there is no shard {} of {}: shards count from 1 to {}", shard.index,
                    shard.count, std::max<std::uint64_t>(shard.count, 1)));
}

std::vector<const plan::Run*> OrderRuns(const plan::Plan& plan, ShardChoice shard) {
  CheckShard(shard);
  const std::string hash = plan.Sha256();
  std::vector<DetectorGroup> groups = GroupByDetector(plan);
  const auto shards = ShardOfEach(groups, shard.count);
  std::vector<const plan::Run*> order;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (shards[i] != shard.index) continue;
    DetectorGroup& group = groups[i];
    Shuffle(group.runs, plan::StreamSeed(group.rep, hash + group.point));
    order.insert(order.end(), group.runs.begin(), group.runs.end());
  }
  return order;
}

std::vector<std::vector<const plan::Run*>> ListShards(const plan::Plan& plan, std::uint64_t count) {
  const std::vector<DetectorGroup> groups = GroupByDetector(plan);
  const auto shards = ShardOfEach(groups, count);
  std::vector<std::vector<const plan::Run*>> all(std::min<std::uint64_t>(count, groups.size()));
  for (std::size_t i = 0; i < groups.size(); ++i) {
    auto& runs = all[shards[i] - 1];
    runs.insert(runs.end(), groups[i].runs.begin(), groups[i].runs.end());
  }
  return all;
}

}  // namespace cdb::schedule
