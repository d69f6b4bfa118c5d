#include "runtime/engine/worker/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <new>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "compiler/analysis/trace.h"
#include "library/confinement.h"
#include "library/detectors/detector.h"
#include "library/scene_error.h"
#include "runtime/engine/detection/detectors.h"
#include "runtime/engine/probes/pair_referee.h"
#include "runtime/engine/probes/processor_time.h"
#include "runtime/engine/worker/replay_pairs.h"
#include "runtime/engine/worker/run_scene.h"
#include "runtime/engine/world/timed_world.h"
#include "runtime/protocol/trace_memory.h"

namespace cdb::worker {
namespace {

/// The trace's bodies as a detector sees them.
class TracedScene {
 public:
  explicit TracedScene(int fd) : trace_(fd), boxes_(trace_.shape().bodies) {
    for (const protocol::TraceFilter& filter : trace_.filters())
      filters_.push_back({filter.group, filter.mask, filter.is_fixed != 0});
    scene_.size = boxes_.size();
    scene_.boxes = boxes_;
    scene_.filters = filters_;
  }

  const protocol::TraceShape& shape() const { return trace_.shape(); }
  const Scene& scene() const { return scene_; }

  /// Neighbours on a deforming mesh always touch: they are not asked for.
  bool IsAsked(const Pair& pair) const {
    const auto& corners = trace_.corners();
    return corners.empty() || !deforming::AreNeighbours(corners[pair.a], corners[pair.b]);
  }

  bool IsOfMesh() const { return shape().primitives.has_value(); }

  /// Reads the vertices of a cycle of a deforming mesh, for Meet.
  void ReadVertices(std::uint64_t cycle) {
    ReadFrame(cycle, from_);
    if (deforming::IsSwept(*shape().primitives)) ReadFrame(cycle + 1, to_);
  }
  bool Meet(const Pair& pair) const {
    const auto& corners = trace_.corners();
    return deforming::Meet(*shape().primitives, corners[pair.a], corners[pair.b], from_, to_);
  }

  void MoveTo(std::uint64_t cycle) {
    const double* side = trace_.Read(cycle).data();
    for (Box& box : boxes_) {
      box = {{side[0], side[1], side[2]}, {side[3], side[4], side[5]}};
      side += protocol::kBoxSize;
    }
  }

 private:
  void ReadFrame(std::uint64_t frame, std::vector<Eigen::Vector3d>& to) {
    const std::vector<double> coordinates = trace_.ReadVertices(frame);
    to.resize(coordinates.size() / 3);
    for (std::size_t i = 0; i < to.size(); ++i)
      to[i] = {coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]};
  }

  protocol::TraceReader trace_;
  std::vector<Eigen::Vector3d> from_, to_;  ///< of a deforming mesh
  std::vector<Box> boxes_;
  std::vector<Filter> filters_;
  Scene scene_;
};

detection::NamedDetector MakeFor(const plan::Scene& scene, const TracedScene& traced) {
  const std::string_view name = scene.world.WordOr("detector");
  detection::NamedDetector detector = detection::MakeDetector(name, scene);
  detection::CheckHolds(name, detector.max_bodies, traced.shape().bodies);
  if (!HasAny(detector.phases, cdb::kBroad) || HasAny(detector.phases, cdb::kNeedsPoses))
    throw library::SceneError(
        fmt::format("detector `{}` {}, but a trace has only boxes; run it in a live world", name,
                    !HasAny(detector.phases, cdb::kBroad) ? "lists no pairs" : "needs poses"));
  return detector;
}

/// Puts the lower body of each pair first, as a live world does. Fails the run if an entry is not a
/// pair of bodies.
void PutInShape(const TracedScene& traced, std::string_view name, std::span<Pair> pairs) {
  const std::size_t bodies = traced.scene().size;
  for (Pair& pair : pairs) {
    if (pair.a > pair.b) std::swap(pair.a, pair.b);
    if (pair.a == pair.b || pair.b >= bodies)
      throw library::SceneError(
          fmt::format("detector `{}` lists the pair {}, {}; a pair must be two of the bodies 0 to "
                      "{}",
                      name, pair.a, pair.b, bodies - 1));
  }
}

/// The cycles of a run on its trace.
class Replay {
 public:
  Replay(const plan::Run& run, protocol::Recording& recording, int trace_fd)
      : run_(run),
        recording_(recording),
        traced_(trace_fd),
        warmup_(run.scene.world.Count("warmup")),
        cycles_(run.scene.world.Count("cycles")) {
    CheckCycles(traced_.shape(), warmup_ + cycles_);
  }

  void Time() {
    protocol::RecordingHeader& header = recording_.header();
    const bool records_heap = !recording_.Reals("heap").empty();
    const std::int64_t build_begin = world::Now();
    const detection::NamedDetector detector = Prepared();
    header.scalars.build_ns = static_cast<double>(world::Now() - build_begin);
    std::optional<probes::ProcessorTime> processor_time;
    for (std::uint64_t i = 0; i < warmup_ + cycles_; ++i) {
      if (i == warmup_) processor_time.emplace();
      traced_.MoveTo(i);
      pairs_.clear();
      const world::Stamp begin = world::TakeStamp();
      detector.detector->FindPairs(traced_.scene(), pairs_);
      const world::Stamp spent = world::TakeStamp() - begin;
      PutInShape(traced_, detector.name, pairs_);
      // The same filter as in the engine.
      std::erase_if(pairs_, [this](const Pair& pair) {
        return !traced_.scene().MayCollide(pair.a, pair.b) || !traced_.IsAsked(pair);
      });
      if (i < warmup_) continue;
      const std::uint64_t cycle = i - warmup_;
      if (records_heap) recording_.Put("heap", cycle, probes::HeapBytes());
      world::PhaseStamps phases = {};
      for (const protocol::Phase phase :
           {protocol::Phase::kBroad, protocol::Phase::kDetect, protocol::Phase::kStep})
        phases[protocol::IndexOf(phase)] = spent;
      world::RecordPhases(phases, cycle, recording_);
      recording_.Put("pairs", cycle, SeriesCount(pairs_.size()));
      header.cycles_done.store(cycle + 1, std::memory_order_release);
    }
    if (processor_time) processor_time->Store(header.scalars);
    header.state_hash = HashOf(pairs_);
    header.scalars.peak_rss_bytes = probes::PeakRssBytes();
    header.scalars.harness_ns = HarnessNs();
  }

  /// Runs the same cycles again with a new detector, and compares its pairs with brute force, and,
  /// on a deforming mesh, with the collisions among these.
  void Judge() {
    if (recording_.Ints("missed_pairs").empty()) return;
    const detection::NamedDetector detector = Prepared();
    for (std::uint64_t i = 0; i < warmup_ + cycles_; ++i) {
      traced_.MoveTo(i);
      pairs_.clear();
      detector.detector->FindPairs(traced_.scene(), pairs_);
      PutInShape(traced_, detector.name, pairs_);
      if (i < warmup_) continue;
      detectors::PairFilter collides;
      if (traced_.IsOfMesh()) {
        traced_.ReadVertices(i);
        collides = [this](const Pair& pair) { return traced_.Meet(pair); };
      }
      probes::RecordPairFaults(
          traced_.scene(), pairs_, i - warmup_, recording_,
          [this](const Pair& pair) { return traced_.IsAsked(pair); }, collides);
    }
  }

 private:
  /// Overhead of a cycle: its two time stamps, and the call of a detector that does nothing.
  double HarnessNs() {
    const detection::NamedDetector idle = detection::MakeDetector("null", run_.scene);
    std::vector<Pair> none;
    return MedianNs([&] {
      static_cast<void>(world::TakeStamp());
      idle.detector->FindPairs(traced_.scene(), none);
      static_cast<void>(world::TakeStamp());
    });
  }

  detection::NamedDetector Prepared() {
    traced_.MoveTo(0);
    detection::NamedDetector detector = MakeFor(run_.scene, traced_);
    detector.detector->Prepare(traced_.scene());
    return detector;
  }

  const plan::Run& run_;
  protocol::Recording& recording_;
  TracedScene traced_;
  const std::uint64_t warmup_, cycles_;
  std::vector<Pair> pairs_;
};

void ReplayBoxes(const plan::Run& run, protocol::Recording& recording, int trace_fd) {
  if (!run.scene.plugins.empty()) library::Confine();
  Replay replay(run, recording, trace_fd);
  replay.Time();
  replay.Judge();
}

}  // namespace

std::int32_t SeriesCount(std::size_t count) {
  return static_cast<std::int32_t>(
      std::min<std::size_t>(count, std::numeric_limits<std::int32_t>::max()));
}

std::string HashOf(std::vector<Pair> pairs) {
  std::ranges::sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const Pair& pair : pairs)
    for (std::uint64_t bits = std::uint64_t{pair.a} << 32 | pair.b, i = 0; i < 8; ++i, bits >>= 8)
      hash = (hash ^ (bits & 0xff)) * 0x100000001b3;
  return fmt::format("{:016x}", hash);
}

void CheckCycles(const protocol::TraceShape& trace, std::uint64_t cycles) {
  if (cycles > trace.cycles)
    throw library::SceneError(
        fmt::format("the trace has {} cycles, but this run has {}", trace.cycles, cycles));
}

void ReplayTrace(const plan::Run& run, protocol::Recording& recording, int trace_fd) {
  probes::BeginHeap();
  try {
    if (analysis::IsOnPairs(run.scene)) {
      ReplayPairs(run, recording, trace_fd);
    } else {
      ReplayBoxes(run, recording, trace_fd);
    }
    recording.header().outcome.store(protocol::WorkerOutcome::kDone, std::memory_order_release);
  } catch (const std::bad_alloc&) {
    ReportFailure(recording, std::string(protocol::kOutOfMemory) + "; a smaller trace needs less");
  } catch (const std::exception& error) {
    ReportFailure(recording, error.what());
  } catch (...) {
    ReportFailure(recording, "the detector throws something other than a std::exception");
  }
}

}  // namespace cdb::worker
