#include "runtime/engine/worker/run_configurations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "compiler/analysis/reference.h"
#include "library/confinement.h"
#include "library/layouts/initial_state.h"
#include "library/layouts/placement.h"
#include "library/objects/solid_factory.h"
#include "library/robots/kinematic_tree.h"
#include "library/robots/lanes.h"
#include "runtime/engine/probes/pair_referee.h"
#include "runtime/engine/probes/probes.h"
#include "runtime/engine/probes/processor_time.h"
#include "runtime/engine/worker/least_distance.h"
#include "runtime/engine/worker/replay.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/engine.h"
#include "runtime/engine/world/manifolds.h"
#include "runtime/omissions/omissions.h"

namespace cdb::worker {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
/// Rounds of lanes between two time stamps.
constexpr std::size_t kBlock = 8;

/// The pairs of bodies that overlap in a configuration, of their indices, the smaller first.
struct Hits {
  std::vector<probes::BodyPair> pairs;
  std::size_t self = 0, scene = 0;
  bool Any() const { return !pairs.empty(); }
};

/// FNV-1a over the hits of one configuration after the other.
class HitHash {
 public:
  void Add(const Hits& hits) {
    Add(hits.pairs.size());
    for (const auto& [a, b] : hits.pairs) Add(std::uint64_t{a} << 32 | b);
  }
  void Add(std::uint64_t bits) {
    for (int i = 0; i < 8; ++i, bits >>= 8) hash_ = (hash_ ^ (bits & 0xff)) * 0x100000001b3;
  }
  std::string Text() const { return fmt::format("{:016x}", hash_); }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325;
};

/// The bodies of the scene, whose robot is moved from configuration to configuration.
class ConfiguredWorld {
 public:
  ConfiguredWorld(const plan::Scene& scene, const layouts::InitialState& state,
                  std::span<const double> positions)
      : tree_(scene, state),
        positions_(positions),
        engine_(scene, state, omissions::KeepEverything(scene)) {}

  world::Engine& engine() { return engine_; }
  const robots::KinematicTree& tree() const { return tree_; }
  /// In double, by object.
  const std::vector<objects::Pose>& poses() const { return poses_; }
  std::size_t count() const { return positions_.size() / tree_.freedoms(); }

  void MoveTo(std::size_t configuration) {
    tree_.PosesAt(positions_.subspan(configuration * tree_.freedoms(), tree_.freedoms()), poses_);
    for (const std::size_t object : tree_.moved()) {
      btRigidBody& body = *engine_.objects()[object];
      const objects::Pose& pose = poses_[object];
      const Eigen::Quaterniond& turn = pose.orientation;
      const btTransform transform(
          btQuaternion(static_cast<btScalar>(turn.x()), static_cast<btScalar>(turn.y()),
                       static_cast<btScalar>(turn.z()), static_cast<btScalar>(turn.w())),
          world::ToBullet(pose.position));
      body.setWorldTransform(transform);
      body.setInterpolationWorldTransform(transform);
    }
    ForgetContacts();
  }

  void Detect() {
    engine_.Detect();
    // What does not move keeps its box from then on.
    engine_.world().setForceUpdateAllAabbs(false);
  }

  Hits FindHits() {
    Hits hits;
    for (const btPersistentManifold& manifold : world::TouchingManifolds(engine_.world())) {
      bool overlap = false;
      for (int i = 0; i < manifold.getNumContacts(); ++i)
        overlap = overlap || manifold.getContactPoint(i).getDistance() <= 0;
      if (overlap)
        hits.pairs.push_back(
            std::minmax({static_cast<std::uint32_t>(manifold.getBody0()->getUserIndex()),
                         static_cast<std::uint32_t>(manifold.getBody1()->getUserIndex())}));
    }
    // A compound may have several manifolds.
    std::ranges::sort(hits.pairs);
    hits.pairs.erase(std::unique(hits.pairs.begin(), hits.pairs.end()), hits.pairs.end());
    for (const auto& [a, b] : hits.pairs) ++(IsLink(a) && IsLink(b) ? hits.self : hits.scene);
    return hits;
  }

 private:
  bool IsLink(std::uint32_t body) const {
    return body < engine_.objects().size() && tree_.IsLink(body);
  }

  /// Bullet would keep contacts of the last configuration beside those of this one.
  void ForgetContacts() {
    btDispatcher& dispatcher = *engine_.world().getDispatcher();
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
      dispatcher.getManifoldByIndexInternal(i)->clearManifold();
  }

  const robots::KinematicTree tree_;
  const std::span<const double> positions_;
  world::Engine engine_;
  std::vector<objects::Pose> poses_;
};

class ConfigurationRun {
 public:
  ConfigurationRun(const plan::Run& run, protocol::Recording& recording, Streams streams)
      : scene_(run.scene),
        recording_(recording),
        streams_(streams),
        cycles_(run.scene.world.Count("cycles")),
        warmup_(run.scene.world.Count("warmup")),
        asks_for_hits_alone_(run.scene.world.WordOr("configurations.ask") == "hit"),
        asks_for_distance_(run.scene.world.WordOr("configurations.ask") == "distance") {}

  void Run() {
    if (scene_.world.WordOr("configurations.by") == "lanes") {
      CheckInLanes();
    } else {
      Time();
      Judge();
    }
  }

  void Prepare() {
    protocol::RecordingHeader& header = recording_.header();
    const std::int64_t begin = world::Now();
    state_ = layouts::DrawObjects(scene_);
    header.scalars.fill_fraction = state_.fill_fraction;
    header.models = objects::ModelsText(state_.forms);
    layouts::Place(scene_, state_);
    positions_ = robots::PositionsOf(scene_);
    header.scalars.place_ns = static_cast<double>(world::Now() - begin);
  }

 private:
  void Time() {
    protocol::RecordingHeader& header = recording_.header();
    const std::int64_t begin = world::Now();
    ConfiguredWorld world(scene_, state_, positions_);
    header.scalars.build_ns = static_cast<double>(world::Now() - begin);
    header.decisions = analysis::DecisionsText(world.engine().omissions().decisions);
    header.scalars.harness_ns = HarnessNs(scene_, world.engine());
    probes::Probes probes(scene_, world.engine(), recording_, streams_.contacts_fd);
    const auto duration = recording_.Reals("duration");
    LeastDistance distance(world.engine(), world.tree());
    WarmUp(world);
    probes.Begin();
    HitHash hash;
    const probes::ProcessorTime processor_time;
    for (std::uint64_t cycle = 0; cycle < cycles_; ++cycle) {
      world.MoveTo(cycle);
      world.Detect();
      const std::int64_t asked = world::Now();
      const double least = asks_for_distance_ ? distance.Of(world.poses()) : kNone;
      const auto spent = static_cast<double>(asks_for_distance_ ? world::Now() - asked : 0);
      probes.Record(cycle);
      if (!duration.empty()) {
        for (const protocol::Phase phase : {protocol::Phase::kSolve, protocol::Phase::kIntegrate})
          duration[protocol::IndexOf(phase) * cycles_ + cycle] = kNone;
        duration[protocol::IndexOf(protocol::Phase::kStep) * cycles_ + cycle] += spent;
      }
      recording_.Put("least_distance", cycle, least);
      const Hits hits = world.FindHits();
      hash.Add(hits);
      Record(cycle, hits);
      header.cycles_done.store(cycle + 1, std::memory_order_release);
    }
    processor_time.Store(header.scalars);
    header.state_hash = hash.Text();
    header.scalars.peak_rss_bytes = probes::PeakRssBytes();
  }

  /// Finds the contacts of the same configurations again, in a new world, and compares them with
  /// exact overlaps.
  void Judge() {
    if (!scene_.world.Lists("record", "pairs")) return;
    plan::Scene quiet = scene_;
    quiet.world.Set("record", schema::WordList{});
    ConfiguredWorld world(quiet, state_, positions_);
    probes::PairReferee referee(world.engine(), recording_);
    LeastDistance distance(world.engine(), world.tree());
    WarmUp(world);
    HitHash hash;
    for (std::uint64_t cycle = 0; cycle < cycles_; ++cycle) {
      world.MoveTo(cycle);
      referee.BeforeStep();
      world.Detect();
      referee.AfterStep(cycle);
      hash.Add(world.FindHits());
      const probes::ExactContacts& exact = referee.contacts();
      recording_.Put("exact_hit", cycle,
                     std::int32_t{!exact.overlaps.empty() ? 1
                                  : exact.AreAllApart()   ? 0
                                                          : -1});
      if (asks_for_distance_)
        recording_.Put("distance_error", cycle,
                       std::abs(distance.Of(world.poses()) - distance.ExactOf(world.poses())));
    }
    const std::string timed = recording_.header().state_hash.str();
    if (hash.Text() != timed)
      throw std::runtime_error(
          fmt::format("the pass that compares with exact overlaps found the hits {}, the timed "
                      "pass {}: this run is not repeatable, and neither pass can be trusted",
                      hash.Text(), timed));
  }

  static void WarmUp(ConfiguredWorld& world, std::uint64_t count) {
    for (std::uint64_t i = 0; i < count; ++i) {
      world.MoveTo(i % world.count());
      world.Detect();
    }
  }
  void WarmUp(ConfiguredWorld& world) const { WarmUp(world, warmup_); }

  /// Many at a time; the time of each is its share.
  void CheckInLanes() {
    protocol::RecordingHeader& header = recording_.header();
    const std::int64_t begin = world::Now();
    robots::LaneChecker checker(scene_, state_);
    header.scalars.build_ns = static_cast<double>(world::Now() - begin);
    header.scalars.harness_ns = MedianNs([] {
      for (int stamp = 0; stamp < 2; ++stamp) static_cast<void>(world::Now());
    });
    const std::span<const double> positions(positions_);
    const std::size_t freedoms = checker.tree().freedoms(), block = kBlock * checker.lanes();
    const auto duration = recording_.Reals("duration");
    const bool records_heap = !recording_.Reals("heap").empty();
    std::vector<std::uint8_t> hits(block);
    // Without a broad phase, all that may touch.
    const std::int32_t pairs =
        SeriesCount(checker.balls().with_obstacles.size() + checker.balls().with_links.size());
    const auto check = [&](std::size_t first) {
      const std::size_t count = std::min(block, positions.size() / freedoms - first);
      hits.resize(count);
      checker.Check(positions.subspan(first * freedoms, count * freedoms), hits);
    };
    for (std::uint64_t i = 0; i < warmup_; i += block) check(i % cycles_);
    HitHash hash;
    const probes::ProcessorTime processor_time;
    for (std::uint64_t cycle = 0; cycle < cycles_;) {
      const std::int64_t stamp = world::Now();
      check(cycle);
      const double share =
          static_cast<double>(world::Now() - stamp) / static_cast<double>(hits.size());
      for (const std::uint8_t hit : hits) {
        if (!duration.empty())
          for (const protocol::Phase phase : {protocol::Phase::kDetect, protocol::Phase::kStep})
            duration[protocol::IndexOf(phase) * cycles_ + cycle] = share;
        if (records_heap) recording_.Put("heap", cycle, probes::HeapBytes());
        recording_.Put("hit", cycle, std::int32_t{hit});
        recording_.Put("pairs", cycle, pairs);
        hash.Add(hit);
        ++cycle;
      }
      header.cycles_done.store(cycle, std::memory_order_release);
    }
    processor_time.Store(header.scalars);
    header.state_hash = hash.Text();
    header.scalars.peak_rss_bytes = probes::PeakRssBytes();
    if (scene_.world.Lists("record", "pairs")) JudgeLanes(checker);
  }

  void JudgeLanes(const robots::LaneChecker& checker) {
    const std::size_t freedoms = checker.tree().freedoms();
    std::vector<objects::Pose> poses;
    for (std::uint64_t cycle = 0; cycle < cycles_; ++cycle) {
      checker.tree().PosesAt(std::span(positions_).subspan(cycle * freedoms, freedoms), poses);
      const std::optional<bool> hits = robots::HitsExactly(checker.balls(), state_.objects, poses);
      recording_.Put("exact_hit", cycle, hits ? std::int32_t{*hits} : std::int32_t{-1});
    }
  }

  void Record(std::uint64_t cycle, const Hits& hits) {
    const auto count = [this](std::size_t pairs) {
      return asks_for_hits_alone_ ? std::int32_t{-1} : static_cast<std::int32_t>(pairs);
    };
    recording_.Put("hit", cycle, std::int32_t{hits.Any()});
    recording_.Put("self_hits", cycle, count(hits.self));
    recording_.Put("scene_hits", cycle, count(hits.scene));
  }

  const plan::Scene& scene_;
  protocol::Recording& recording_;
  const Streams streams_;
  const std::uint64_t cycles_, warmup_;
  const bool asks_for_hits_alone_, asks_for_distance_;
  layouts::InitialState state_;
  std::vector<double> positions_;
};

}  // namespace

void RunConfigurations(const plan::Run& run, protocol::Recording& recording, Streams streams) {
  probes::BeginHeap();
  try {
    ConfigurationRun configurations(run, recording, streams);
    configurations.Prepare();
    probes::BeginPeak();
    // Models are decomposed by then, and no code of a plug-in has run.
    if (!run.scene.plugins.empty()) library::Confine();
    configurations.Run();
    recording.header().outcome.store(protocol::WorkerOutcome::kDone, std::memory_order_release);
  } catch (const std::bad_alloc&) {
    ReportFailure(recording,
                  std::string(protocol::kOutOfMemory) + "; fewer configurations need less");
  } catch (const std::exception& error) {
    ReportFailure(recording, error.what());
  }
}

}  // namespace cdb::worker
