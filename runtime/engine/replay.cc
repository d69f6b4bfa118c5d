#include "runtime/engine/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "library/detectors/detector.h"
#include "library/scene_error.h"
#include "runtime/engine/detectors.h"
#include "runtime/engine/memory.h"
#include "runtime/engine/run_scene.h"
#include "runtime/engine/timed_world.h"
#include "runtime/measure/trace_memory.h"

namespace cdb::runtime {
namespace {

/// The trace's bodies as a detector sees them.
class TracedScene {
 public:
  explicit TracedScene(int fd) : trace_(fd), boxes_(trace_.shape().bodies) {
    for (const TraceFilter& filter : trace_.filters())
      filters_.push_back({filter.group, filter.mask, filter.is_fixed != 0});
    scene_.size = boxes_.size();
    scene_.boxes = boxes_;
    scene_.filters = filters_;
  }

  const TraceShape& shape() const { return trace_.shape(); }
  const Scene& scene() const { return scene_; }

  void MoveTo(std::uint64_t cycle) {
    const double* side = trace_.Read(cycle).data();
    for (Box& box : boxes_) {
      box = {{side[0], side[1], side[2]}, {side[3], side[4], side[5]}};
      side += kBoxSize;
    }
  }

 private:
  TraceReader trace_;
  std::vector<Box> boxes_;
  std::vector<Filter> filters_;
  Scene scene_;
};

NamedDetector MakeFor(const compiler::Scene& scene, const TracedScene& traced) {
  const std::string_view name = scene.world.WordOr("detector");
  NamedDetector detector = MakeDetector(name, scene);
  CheckHolds(name, detector.max_bodies, traced.shape().bodies);
  if ((detector.phases & cdb::kBroad) == 0 || (detector.phases & cdb::kNeedsPoses) != 0)
    throw library::SceneError(
        fmt::format("detector `{}` {}, and a trace has boxes alone; run it in a live world", name,
                    (detector.phases & cdb::kBroad) == 0 ? "lists no pairs" : "needs poses"));
  return detector;
}

/// Drops pairs that may not collide, as the engine does; refuses what is no pair of bodies.
void KeepAllowed(const TracedScene& traced, std::string_view name, std::vector<Pair>& pairs) {
  const Scene& scene = traced.scene();
  for (const Pair& pair : pairs)
    if (!(pair.a < pair.b && pair.b < scene.size))
      throw library::SceneError(
          fmt::format("detector `{}` lists the pair {}, {}; a pair is two of the bodies 0 to {}, "
                      "the lower one first",
                      name, pair.a, pair.b, scene.size - 1));
  std::erase_if(pairs, [&](const Pair& pair) { return !scene.MayCollide(pair.a, pair.b); });
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

void Replay(const compiler::Run& run, Recording& recording, int trace_fd) {
  RecordingHeader& header = recording.header();
  TracedScene traced(trace_fd);
  const std::uint64_t warmup = run.scene.world.Count("warmup");
  const std::uint64_t cycles = run.scene.world.Count("cycles");
  if (warmup + cycles > traced.shape().cycles)
    throw library::SceneError(fmt::format("the trace has {} cycles, and this run has {}",
                                          traced.shape().cycles, warmup + cycles));
  const auto duration = recording.Reals("duration"), heap = recording.Reals("heap");
  const auto counts = recording.Ints("pairs");

  traced.MoveTo(0);
  const std::int64_t build_begin = Now();
  const NamedDetector detector = MakeFor(run.scene, traced);
  detector.detector->Prepare(traced.scene());
  header.build_ns = static_cast<double>(Now() - build_begin);

  std::vector<Pair> pairs;
  for (std::uint64_t i = 0; i < warmup + cycles; ++i) {
    traced.MoveTo(i);
    pairs.clear();
    const std::int64_t begin = Now();
    detector.detector->FindPairs(traced.scene(), pairs);
    const std::int64_t end = Now();
    KeepAllowed(traced, detector.name, pairs);
    if (i < warmup) continue;
    const std::uint64_t cycle = i - warmup;
    if (!heap.empty()) heap[cycle] = HeapBytes();
    if (!duration.empty())
      for (const Phase phase : {kBroad, kDetect, kStep})
        duration[phase * cycles + cycle] = static_cast<double>(end - begin);
    if (!counts.empty())
      counts[cycle] = static_cast<std::int32_t>(
          std::min<std::size_t>(pairs.size(), std::numeric_limits<std::int32_t>::max()));
    header.cycles_done.store(cycle + 1, std::memory_order_release);
  }
  const std::string hash = HashOf(std::move(pairs));
  std::memcpy(header.state_hash, hash.c_str(), hash.size() + 1);
  header.peak_rss_bytes = PeakRssBytes();
}

}  // namespace

void ReplayTrace(const compiler::Run& run, Recording& recording, int trace_fd) {
  try {
    Replay(run, recording, trace_fd);
    recording.header().outcome.store(WorkerOutcome::kDone, std::memory_order_release);
  } catch (const std::bad_alloc&) {
    ReportFailure(recording, "out of memory; a smaller trace needs less");
  } catch (const std::exception& error) {
    ReportFailure(recording, error.what());
  } catch (...) {
    ReportFailure(recording, "the detector throws what is no std::exception");
  }
}

}  // namespace cdb::runtime
