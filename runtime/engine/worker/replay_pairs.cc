#include "runtime/engine/worker/replay_pairs.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "compiler/yaml/plan_yaml.h"
#include "library/confinement.h"
#include "library/detectors/bullet/vectors.h"
#include "library/layouts/initial_state.h"
#include "library/scene_error.h"
#include "runtime/engine/detection/adapter_dispatcher.h"
#include "runtime/engine/detection/detectors.h"
#include "runtime/engine/probes/pair_referee.h"
#include "runtime/engine/probes/processor_time.h"
#include "runtime/engine/worker/replay.h"
#include "runtime/engine/worker/run_scene.h"
#include "runtime/engine/world/engine.h"
#include "runtime/engine/world/manifolds.h"
#include "runtime/omissions/omissions.h"
#include "runtime/protocol/trace_memory.h"

namespace cdb::worker {
namespace {

constexpr std::string_view kBullet = "bullet";

/// In a run. Each takes about 0.1 ms.
constexpr std::size_t kMostComparedInRun = 100'000;

/// The broad phase of the recorded run.
class RecordedPairs final : public Detector {
 public:
  std::vector<Pair> pairs;  ///< of the current cycle
  void FindPairs(const Scene&, std::vector<Pair>& found) override { found = pairs; }
};

/// Clocks FindContacts of another.
class Clocked final : public Detector {
 public:
  explicit Clocked(std::shared_ptr<Detector> detector) : detector_(std::move(detector)) {}
  world::Stamp spent;  ///< in the last call

  void Prepare(const Scene& scene) override { detector_->Prepare(scene); }
  bool Handles(const Scene& scene, Id a, Id b) const override {
    return detector_->Handles(scene, a, b);
  }
  void FindContacts(const Scene& scene, std::span<const Pair> pairs,
                    std::vector<Contact>& contacts) override {
    const world::Stamp begin = world::TakeStamp();
    detector_->FindContacts(scene, pairs, contacts);
    spent = world::TakeStamp() - begin;
  }

 private:
  std::shared_ptr<Detector> detector_;
};

objects::Pose PoseOf(const double* frame) {
  Eigen::Matrix3d axes;
  for (int axis = 0; axis < 3; ++axis)
    axes.col(axis) = Eigen::Map<const Eigen::Vector3d>(frame + 3 + 3 * axis);
  return {Eigen::Map<const Eigen::Vector3d>(frame), Eigen::Quaterniond(axes).normalized()};
}

btTransform TransformOf(const double* frame) {
  const auto at = [frame](int i) { return static_cast<btScalar>(frame[i]); };
  return btTransform(btMatrix3x3(at(3), at(6), at(9), at(4), at(7), at(10), at(5), at(8), at(11)),
                     btVector3(at(0), at(1), at(2)));
}

/// The scene of the recorded run, with its bodies where they were in the first cycle.
struct RecordedScene {
  plan::Scene scene;
  layouts::InitialState state;
  omissions::Omissions omissions;

  explicit RecordedScene(protocol::TraceReader& trace)
      : scene(yaml::RunFromYaml(trace.ReadRunText(), "trace").scene) {
    scene.world.Set("record", schema::WordList{});
    scene.plugins.clear();
    state = layouts::DrawObjects(scene);
    omissions = omissions::KeepEverything(scene);
    const auto walls = static_cast<std::uint8_t>(trace.walls());
    const auto bodies = state.objects.size() + static_cast<std::size_t>(std::popcount(walls));
    if (bodies != trace.shape().bodies ||
        (walls & ~static_cast<unsigned>(omissions::StandingWalls(scene))) != 0)
      throw library::SceneError(fmt::format(
          "the trace has {} bodies, but its run has {}; record it again: cdb trace --pairs --fresh",
          trace.shape().bodies, bodies));
    if (walls != omissions::StandingWalls(scene))
      omissions.walls.assign(state.objects.size(), walls);
    const double* frame = trace.ReadFrames(0).data();
    for (layouts::ObjectState& object : state.objects) {
      object.pose = PoseOf(frame);
      frame += protocol::kFrameSize;
    }
  }
};

/// The bodies of the recorded run and a narrow phase, moved from cycle to cycle.
class PairWorld {
 public:
  PairWorld(const plan::Scene& run, protocol::TraceReader& trace, const RecordedScene& recorded)
      : trace_(trace), recorded_pairs_(std::make_shared<RecordedPairs>()) {
    detection::Detectors detectors;
    detectors.broad = {"trace", cdb::kBroad, 0, recorded_pairs_};
    const std::string_view name = run.world.WordOr("narrow_phase");
    if (name != kBullet) {
      detectors.narrow = detection::MakeNarrowPhase(name, run);
      clocked_ = std::make_shared<Clocked>(detectors.narrow.detector);
      detectors.narrow.detector = clocked_;
    }
    engine_.emplace(recorded.scene, recorded.state, recorded.omissions, detectors);
    for (const auto& body : engine_->objects()) bodies_.push_back(body.get());
    for (const auto& body : engine_->walls()) bodies_.push_back(body.get());
    for (std::size_t i = 0; i < bodies_.size(); ++i)
      if (bodies_[i]->isStaticOrKinematicObject() != (trace_.filters()[i].is_fixed != 0))
        throw library::SceneError(fmt::format(
            "body {} of the trace is {}fixed, but not in its run; record it again: cdb trace "
            "--pairs --fresh",
            i, trace_.filters()[i].is_fixed != 0 ? "" : "not "));
    engine_->world().getDispatchInfo().m_timeStep = engine_->timestep();
  }

  world::Engine& engine() { return *engine_; }
  const std::vector<Pair>& pairs() const { return recorded_pairs_->pairs; }

  /// Puts the bodies where they were in the cycle, and finds their contacts. Returns what the
  /// narrow phase took.
  world::Stamp Detect(std::uint64_t cycle) {
    Place(cycle);
    TakePairs(cycle);
    if (clocked_ != nullptr) ForgetContacts(/*of_detector=*/true);
    btDispatcher& dispatcher = *engine_->world().getDispatcher();
    btOverlappingPairCache& cache = *engine_->world().getPairCache();
    const world::Stamp clean_begin = world::TakeStamp();
    for (btBroadphasePair* pair : gone_) cache.cleanOverlappingPair(*pair, &dispatcher);
    const world::Stamp clean_end = world::TakeStamp();
    engine_->world().getBroadphase()->calculateOverlappingPairs(&dispatcher);
    const world::Stamp begin = world::TakeStamp();
    dispatcher.dispatchAllCollisionPairs(&cache, engine_->world().getDispatchInfo(), &dispatcher);
    const world::Stamp end = world::TakeStamp();
    return clocked_ != nullptr ? clocked_->spent : (clean_end - clean_begin) + (end - begin);
  }

  /// The pairs of the cycle that the narrow phase does not handle.
  std::size_t CountUnhandled() {
    if (clocked_ == nullptr) return 0;
    const auto pairs = KeptPairs();
    return pairs.size() - static_cast<std::size_t>(std::ranges::count_if(
                              pairs, detection::AdapterDispatcher::IsDetectors));
  }

  /// The pairs of the cycle that the narrow phase handles, by the indices of the referee. Drops the
  /// contacts of the others, which are not its own.
  std::vector<probes::BodyPair> TakeHandled() {
    std::vector<probes::BodyPair> all;
    const auto index = [](const btBroadphaseProxy* proxy) {
      return static_cast<std::uint32_t>(
          static_cast<const btCollisionObject*>(proxy->m_clientObject)->getUserIndex());
    };
    if (clocked_ != nullptr) ForgetContacts(/*of_detector=*/false);
    for (const btBroadphasePair& pair : KeptPairs())
      if (clocked_ == nullptr || detection::AdapterDispatcher::IsDetectors(pair))
        all.push_back(std::minmax({index(pair.m_pProxy0), index(pair.m_pProxy1)}));
    std::ranges::sort(all);
    return all;
  }

 private:
  std::span<btBroadphasePair> KeptPairs() {
    btOverlappingPairCache& cache = *engine_->world().getPairCache();
    return {cache.getOverlappingPairArrayPtr(),
            static_cast<std::size_t>(cache.getNumOverlappingPairs())};
  }

  /// Drops the contacts of the pairs that the detector handles, or of the others. Bullet would keep
  /// those of earlier cycles beside those of this one.
  void ForgetContacts(bool of_detector) {
    manifolds_.resizeNoInitialize(0);
    for (const btBroadphasePair& pair : KeptPairs())
      if (detection::AdapterDispatcher::IsDetectors(pair) == of_detector &&
          pair.m_algorithm != nullptr)
        pair.m_algorithm->getAllContactManifolds(manifolds_);
    for (int i = 0; i < manifolds_.size(); ++i) manifolds_[i]->clearManifold();
  }

  void Place(std::uint64_t cycle) {
    btBroadphaseInterface& broad = *engine_->world().getBroadphase();
    const double* frame = trace_.ReadFrames(cycle).data();
    const double* side = trace_.Read(cycle).data();
    for (btRigidBody* body : bodies_) {
      const btTransform pose = TransformOf(frame);
      body->setWorldTransform(pose);
      body->setInterpolationWorldTransform(pose);
      broad.setAabb(body->getBroadphaseHandle(), bullet::ToBullet({side[0], side[1], side[2]}),
                    bullet::ToBullet({side[3], side[4], side[5]}), nullptr);
      frame += protocol::kFrameSize;
      side += protocol::kBoxSize;
    }
  }

  void TakePairs(std::uint64_t cycle) {
    last_pairs_.swap(recorded_pairs_->pairs);
    std::vector<Pair>& pairs = recorded_pairs_->pairs;
    pairs.clear();
    for (const protocol::TracePair& pair : trace_.ReadPairs(cycle))
      pairs.push_back({pair.a, pair.b});
    lost_.clear();
    std::ranges::set_difference(last_pairs_, pairs, std::back_inserter(lost_));
    gone_.clear();
    for (const Pair& pair : lost_) {
      btBroadphasePair* kept = engine_->world().getPairCache()->findPair(
          bodies_[pair.a]->getBroadphaseHandle(), bodies_[pair.b]->getBroadphaseHandle());
      if (kept != nullptr) gone_.push_back(kept);
    }
  }

  protocol::TraceReader& trace_;
  std::shared_ptr<RecordedPairs> recorded_pairs_;
  std::shared_ptr<Clocked> clocked_;  ///< null: Bullet's narrow phase
  std::optional<world::Engine> engine_;
  std::vector<btRigidBody*> bodies_;  ///< in the order of the trace
  std::vector<Pair> last_pairs_, lost_;
  std::vector<btBroadphasePair*> gone_;
  btManifoldArray manifolds_;
};

void RecordContacts(btCollisionWorld& world, std::uint64_t cycle, protocol::Recording& recording) {
  std::size_t manifolds = 0, contacts = 0;
  for (const btPersistentManifold& manifold : world::TouchingManifolds(world)) {
    ++manifolds;
    contacts += static_cast<std::size_t>(manifold.getNumContacts());
  }
  recording.Put("manifolds", cycle, SeriesCount(manifolds));
  recording.Put("contacts", cycle, SeriesCount(contacts));
}

std::vector<Pair> Overlapping(btCollisionWorld& world) {
  std::vector<Pair> pairs;
  for (const btPersistentManifold& manifold : world::TouchingManifolds(world)) {
    const auto [a, b] = std::minmax({static_cast<Id>(manifold.getBody0()->getUserIndex()),
                                     static_cast<Id>(manifold.getBody1()->getUserIndex())});
    for (int j = 0; j < manifold.getNumContacts(); ++j)
      if (manifold.getContactPoint(j).getDistance() <= 0) pairs.push_back({a, b});
  }
  return pairs;
}

/// The cycles of a run on its trace.
class PairReplay {
 public:
  PairReplay(const plan::Run& run, protocol::Recording& recording, int trace_fd)
      : run_(run),
        recording_(recording),
        trace_(trace_fd),
        recorded_(trace_),
        warmup_(run.scene.world.Count("warmup")),
        cycles_(run.scene.world.Count("cycles")) {
    CheckCycles(trace_.shape(), warmup_ + cycles_);
  }

  void Time() {
    protocol::RecordingHeader& header = recording_.header();
    const bool records_heap = !recording_.Reals("heap").empty();
    const std::int64_t build_begin = world::Now();
    PairWorld world(run_.scene, trace_, recorded_);
    header.scalars.build_ns = static_cast<double>(world::Now() - build_begin);
    std::optional<probes::ProcessorTime> processor_time;
    for (std::uint64_t i = 0; i < warmup_ + cycles_; ++i) {
      if (i == warmup_) processor_time.emplace();
      const world::Stamp spent = world.Detect(i);
      if (i < warmup_) continue;
      const std::uint64_t cycle = i - warmup_;
      if (records_heap) recording_.Put("heap", cycle, probes::HeapBytes());
      world::PhaseStamps phases = {};
      for (const protocol::Phase phase :
           {protocol::Phase::kNarrow, protocol::Phase::kDetect, protocol::Phase::kStep})
        phases[protocol::IndexOf(phase)] = spent;
      world::RecordPhases(phases, cycle, recording_);
      recording_.Put("pairs", cycle, SeriesCount(world.pairs().size()));
      recording_.Put("unhandled_pairs", cycle, SeriesCount(world.CountUnhandled()));
      RecordContacts(world.engine().world(), cycle, recording_);
      header.cycles_done.store(cycle + 1, std::memory_order_release);
    }
    if (processor_time) processor_time->Store(header.scalars);
    header.state_hash = HashOf(Overlapping(world.engine().world()));
    header.scalars.peak_rss_bytes = probes::PeakRssBytes();
    // Overhead of a cycle: its time stamps.
    header.scalars.harness_ns = MedianNs([] {
      for (int stamp = 0; stamp < 4; ++stamp) static_cast<void>(world::TakeStamp());
    });
  }

  /// Runs the same cycles again in a new world, and compares the contacts with exact overlaps.
  void Judge() {
    if (recording_.Ints("exact_contacts").empty()) return;
    PairWorld world(run_.scene, trace_, recorded_);
    const std::size_t most =
        std::clamp<std::size_t>(kMostComparedInRun / cycles_, 1, protocol::kMostComparedContacts);
    for (std::uint64_t i = 0; i < warmup_ + cycles_; ++i) {
      world.Detect(i);
      if (i < warmup_) continue;
      const std::vector<probes::BodyPair> handled = world.TakeHandled();
      probes::JudgeContacts(world.engine(), probes::ExactOverlaps(world.engine(), handled, i, most),
                            recording_, i - warmup_);
    }
  }

 private:
  const plan::Run& run_;
  protocol::Recording& recording_;
  protocol::TraceReader trace_;
  const RecordedScene recorded_;
  const std::uint64_t warmup_, cycles_;
};

}  // namespace

void ReplayPairs(const plan::Run& run, protocol::Recording& recording, int trace_fd) {
  PairReplay replay(run, recording, trace_fd);
  // Models are decomposed by then, and no code of a plug-in has run.
  if (!run.scene.plugins.empty()) library::Confine();
  replay.Time();
  replay.Judge();
}

}  // namespace cdb::worker
