#include "runtime/sweep/schedule/order.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "compiler/analysis/trace.h"
#include "library/objects/models.h"
#include "library/scene_error.h"
#include "runtime/protocol/bytes_text.h"
#include "runtime/protocol/samples.h"
#include "runtime/protocol/series.h"
#include "runtime/sweep/process/launcher.h"

namespace cdb::schedule {
namespace {

/// Runs that differ only in the detector, or of rivals in a race.
struct DetectorGroup {
  std::string point;  ///< identifies the scene without its detector, or the race
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

/// The point of a run, with 0 on the axes whose values belong together.
std::vector<std::size_t> PlaceOf(const plan::Plan& plan, const plan::Run& run) {
  std::vector<std::size_t> place = run.at;
  for (std::size_t i = 0; i < place.size(); ++i) {
    const plan::Axis& axis = plan.axes[i];
    if (axis.search || axis.race || axis.parameter == "detector") place[i] = 0;
  }
  return place;
}

/// In grid order, with the repeats one after the other.
std::vector<DetectorGroup> GroupByDetector(const plan::Plan& plan) {
  std::vector<DetectorGroup> groups;
  std::unordered_set<std::string_view> seen;
  std::unordered_map<std::string, std::size_t> places;
  const bool has_race = !plan.RaceAxes().empty();
  for (const plan::Run& run : plan.runs) {
    if (!seen.insert(run.id).second) continue;
    const std::string point =
        has_race ? fmt::format("{}", fmt::join(PlaceOf(plan, run), " ")) : PointKey(run);
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

/// Groups that must be in one shard, as indices, and their work.
struct Bundle {
  double work = 0;
  std::vector<std::size_t> groups;
};

/// A number for each point of a plan that is the same for those of one search or race, for
/// detectors at one point, and for searches or races that have a run in common.
class SearchNumbers {
 public:
  explicit SearchNumbers(const plan::Plan& plan) : plan_(plan) {
    std::unordered_map<std::string_view, std::size_t> owners;
    for (const plan::Run& run : plan.runs) {
      const auto [place, is_new] = places_.try_emplace(PlaceOf(plan, run), same_as_.size());
      if (is_new) same_as_.push_back(place->second);
      const auto [owner, is_first] = owners.try_emplace(run.id, place->second);
      if (!is_first) same_as_[Root(place->second)] = Root(owner->second);
    }
  }

  std::size_t Of(const plan::Run& run) const { return Root(places_.at(PlaceOf(plan_, run))); }

 private:
  std::size_t Root(std::size_t number) const {
    while (same_as_[number] != number) number = same_as_[number];
    return number;
  }

  const plan::Plan& plan_;
  std::map<std::vector<std::size_t>, std::size_t> places_;
  std::vector<std::size_t> same_as_;
};

/// Each group by itself; those of one search or race together, which needs the results of its
/// runs.
std::vector<Bundle> BundlesOf(const plan::Plan& plan, const std::vector<DetectorGroup>& groups) {
  std::optional<SearchNumbers> numbers;
  if (plan.ChoosesRuns()) numbers.emplace(plan);
  std::vector<Bundle> bundles;
  std::map<std::size_t, std::size_t> indices;  // by number
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const std::size_t number = numbers ? numbers->Of(*groups[i].runs[0]) : i;
    const auto [index, is_new] = indices.try_emplace(number, bundles.size());
    if (is_new) bundles.emplace_back();
    bundles[index->second].work += groups[i].work;
    bundles[index->second].groups.push_back(i);
  }
  return bundles;
}

/// The shard of each group, from 1: the heaviest bundle first, each to the shard with the least
/// load so far.
std::vector<std::uint64_t> ShardOfEach(const plan::Plan& plan,
                                       const std::vector<DetectorGroup>& groups,
                                       std::uint64_t count) {
  std::vector<Bundle> bundles = BundlesOf(plan, groups);
  std::ranges::stable_sort(bundles, std::greater<>{}, &Bundle::work);
  std::map<std::pair<double, std::uint64_t>, int> loads;  // a queue by load, then by index
  for (std::uint64_t i = 1; i <= std::min<std::uint64_t>(count, bundles.size()); ++i)
    loads.emplace(std::pair{0.0, i}, 0);
  std::vector<std::uint64_t> shards(groups.size(), 1);
  for (const Bundle& bundle : bundles) {
    const auto [load, index] = loads.begin()->first;
    loads.erase(loads.begin());
    loads.emplace(std::pair{load + bundle.work, index}, 0);
    for (const std::size_t group : bundle.groups) shards[group] = index;
  }
  return shards;
}

}  // namespace

std::vector<const plan::Run*> ReferencesOf(const plan::Plan& plan,
                                           const std::vector<const plan::Run*>& runs) {
  std::unordered_set<std::string_view> wanted;
  for (const plan::Run* run : runs) wanted.insert({run->reference, run->twin});
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
  const auto shards = ShardOfEach(plan, groups, shard.count);
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
  const auto shards = ShardOfEach(plan, groups, count);
  std::vector<std::vector<const plan::Run*>> all(groups.empty() ? 0 : std::ranges::max(shards));
  for (std::size_t i = 0; i < groups.size(); ++i) {
    auto& runs = all[shards[i] - 1];
    runs.insert(runs.end(), groups[i].runs.begin(), groups[i].runs.end());
  }
  return all;
}

namespace {

namespace fs = std::filesystem;

/// A rigid body of Bullet has 700 bytes, and its boxes and pairs take more; 1.9 kB were measured.
constexpr double kBytesOfObject = 1000;
/// No results compress better.
constexpr double kBestCompression = 20;
constexpr double kSecondsOfObject = 10e-9;  // per cycle
constexpr double kSecondsOfRun = 1e-3;      // for its process and its record
constexpr double kMostSeconds = 365.25 * 24 * 3600;
/// Fraction of the free memory; the rest is left to the system.
constexpr double kUsableMemory = 0.8;

double BytesOf(const std::vector<const protocol::Series*>& all,
               const protocol::RunExtents& extents) {
  double bytes = 0;
  for (const protocol::Series* series : all)
    bytes +=
        static_cast<double>(series->ItemBytes()) * static_cast<double>(series->ValueCount(extents));
  return bytes;
}

double SecondsOf(const plan::Run& run) {
  const plan::WorldSettings& world = run.scene.world;
  const double cycles = static_cast<double>(world.Count("cycles") + world.Count("warmup"));
  const double seconds =
      kSecondsOfRun + cycles * static_cast<double>(run.scene.ObjectCount()) * kSecondsOfObject;
  return world.WordOr("timeout").empty() ? std::min(seconds, world.Real("timeout")) : seconds;
}

/// A value of /proc/meminfo, in bytes.
double MemoryInfo(std::string_view wanted) {
  std::ifstream info("/proc/meminfo");
  for (std::string name; info >> name; std::getline(info, name)) {
    double kib = 0;
    if (name == wanted && info >> kib) return kib * 1024;
  }
  return std::numeric_limits<double>::infinity();
}

/// Bytes that the control group (version 2) may use; infinite if there is no limit. Its present
/// usage is not subtracted, because most of it may be cache.
double GroupLimit() {
  std::ifstream file("/sys/fs/cgroup/memory.max");
  double bytes = 0;
  return file >> bytes ? bytes : std::numeric_limits<double>::infinity();
}

/// Throws SceneError for a model that is not on this machine. `checked`: words already looked up.
void CheckModelsOf(const schema::Value& type, std::set<std::string>& checked) {
  if (const schema::Distribution* drawn = schema::AsDistribution(type))
    for (const schema::Value& choice : drawn->arguments) CheckModelsOf(choice, checked);
  const schema::Word* word = schema::AsWord(type);
  if (word == nullptr || !checked.insert(word->text).second) return;
  if (const objects::Model* model = objects::FindModel(word->text))
    objects::PathOf(*model, objects::ModelFolders());
}

}  // namespace

Demand LeastDemand(const std::vector<const plan::Run*>& runs, std::uint64_t jobs) {
  Demand demand;
  protocol::RecordedSeriesOf recorded_by;
  for (const plan::Run* run : runs) {
    const double series = BytesOf(recorded_by.Find(run->scene), protocol::ExtentsOf(run->scene));
    double samples = 0;
    if (const auto shape = protocol::SampleShapeOf(run->scene))
      samples = static_cast<double>(shape->Count() * sizeof(double));
    // Recording and record exist at the same time; samples are those of the run, of its reference
    // and of its twin.
    demand.recorded = std::max(demand.recorded, 2 * (series + 3 * samples));
    demand.disk += 2 / kBestCompression * series;
    demand.time += SecondsOf(*run);
    if (analysis::TraceOf(run->scene)) continue;  // a run on a trace places nothing
    demand.objects = std::max(demand.objects, static_cast<double>(run->scene.ObjectCount()));
  }
  demand.scene = demand.objects * kBytesOfObject;
  demand.time /= static_cast<double>(jobs);
  return demand;
}

Demand LeastDemand(const plan::Plan& plan, std::uint64_t jobs, std::uint64_t parts) {
  const auto pointers = [](const auto& runs) {
    std::vector<const plan::Run*> all;
    for (const plan::Run& run : runs) all.push_back(&run);
    return all;
  };
  Demand demand = LeastDemand(pointers(plan.Bounds()), 1);
  if (plan.whole) {
    demand.disk = LeastDemand(pointers(plan.runs), 1).disk;
    demand.time = static_cast<double>(plan.RunCount()) * kSecondsOfRun;
    for (const plan::Run& run : plan.Bounds()) demand.time = std::max(demand.time, SecondsOf(run));
  }
  demand.time /= static_cast<double>(jobs * parts);
  demand.disk /= static_cast<double>(parts);
  return demand;
}

Capacity WholeMachine() {
  return {std::min(MemoryInfo("MemTotal:"), GroupLimit()), std::numeric_limits<double>::infinity()};
}

Capacity FreeNow(const fs::path& folder) {
  Capacity capacity;
  capacity.memory = kUsableMemory * std::min(MemoryInfo("MemAvailable:"), GroupLimit());
  std::error_code error;
  fs::path at = fs::absolute(folder, error);
  while (!error && !fs::exists(at, error) && at.has_relative_path()) at = at.parent_path();
  struct statvfs status = {};
  if (statvfs(at.c_str(), &status) == 0)
    capacity.disk = static_cast<double>(status.f_bavail) * static_cast<double>(status.f_frsize);
  return capacity;
}

std::string WhyTooLarge(const Demand& demand, const Capacity& capacity) {
  if (demand.recorded + demand.scene > capacity.memory)
    return fmt::format(
        "one run records up to {} and its {:.4g} objects need {} or more, but only {} of memory "
        "are available; use fewer cycles or objects, or record less",
        protocol::BytesText(demand.recorded), demand.objects, protocol::BytesText(demand.scene),
        protocol::BytesText(capacity.memory));
  if (demand.disk > capacity.disk)
    return fmt::format(
        "its results need {} of disk or more, but only {} are available; record less, use fewer "
        "runs or cycles, or another disk (-o)",
        protocol::BytesText(demand.disk), protocol::BytesText(capacity.disk));
  if (demand.time > kMostSeconds)
    return fmt::format(
        "its runs take {:.3g} years or more, at {:g} ns per object and cycle; use fewer runs, "
        "objects or cycles, or set a timeout",
        demand.time / kMostSeconds, kSecondsOfObject * 1e9);
  return {};
}

void CheckFits(const std::string& benchmark, const Demand& demand, const fs::path& folder) {
  const std::string why = WhyTooLarge(demand, FreeNow(folder));
  if (!why.empty())
    throw process::ScheduleError(fmt::format("{}: {}; nothing was started", benchmark, why));
}

void CheckModels(const std::string& benchmark, const std::vector<const plan::Run*>& runs) {
  std::set<std::string> checked;
  try {
    for (const plan::Run* run : runs)
      for (const plan::Group& group : run->scene.groups)
        if (group.settings.Count("quantity") > 0)
          CheckModelsOf(group.settings.Get("type"), checked);
  } catch (const library::SceneError& error) {
    throw process::ScheduleError(
        fmt::format("{}: nothing was started: {}", benchmark, error.what()));
  }
}

}  // namespace cdb::schedule
