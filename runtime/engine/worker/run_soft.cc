#include "runtime/engine/worker/run_soft.h"

#include <new>
#include <optional>
#include <string>
#include <utility>

#include "compiler/analysis/pruning.h"
#include "compiler/analysis/reference.h"
#include "library/layouts/initial_state.h"
#include "library/layouts/placement.h"
#include "runtime/engine/probes/processor_time.h"
#include "runtime/engine/soft/soft_probes.h"
#include "runtime/engine/soft/soft_sampler.h"
#include "runtime/engine/soft/soft_world.h"
#include "runtime/engine/worker/run_scene.h"

namespace cdb::worker {
namespace {

/// The time stamps of a step, ns: two for each phase that is stamped. A world of springs integrates
/// in two parts.
double StampsNs(const plan::Scene& scene) {
  const int stamps = scene.world.WordOr("soft_world") == "springs" ? 12 : 10;
  return MedianNs([stamps] {
    for (int stamp = 0; stamp < stamps; ++stamp) static_cast<void>(world::TakeStamp());
  });
}

void RunCycles(const plan::Scene& scene, soft::SoftWorld& world, protocol::Recording& recording) {
  soft::SoftProbes probes(scene, world, recording);
  for (std::uint64_t i = 0; i < scene.world.Count("warmup"); ++i) world.Step();
  probes.Begin();
  const probes::ProcessorTime processor_time;
  for (std::uint64_t cycle = 0; cycle < scene.world.Count("cycles"); ++cycle) {
    world.Step();
    probes.Record(cycle);
    recording.header().cycles_done.store(cycle + 1, std::memory_order_release);
  }
  processor_time.Store(recording.header().scalars);
}

/// Runs all cycles without a clock, for samples, and for the verdict of a reference run.
void RunWithoutClock(const plan::Scene& scene, soft::SoftWorld& world,
                     protocol::Recording& recording) {
  soft::SoftSampler sampler(scene, world, recording);
  std::optional<soft::SoftProbes> probes;
  if (scene.role == plan::Role::kReference) probes.emplace(scene, world, recording);
  sampler.Begin();
  if (probes) probes->Begin();
  const std::uint64_t steps = scene.world.Count("warmup") + scene.world.Count("cycles");
  for (std::uint64_t i = 0; i < steps; ++i) {
    world.Step();
    sampler.AfterStep();
    if (probes) probes->Record(i);
  }
}

/// Runs the same scene again from the start without a clock. Its motion must be the same.
void RunAgain(const plan::Scene& scene, const soft::SoftWorld& first,
              protocol::Recording& recording) {
  plan::Scene quiet = scene;
  quiet.world.Set("record", schema::WordList{});
  soft::SoftWorld world(quiet, first.initial_state());
  RunWithoutClock(scene, world, recording);
  RequireSameState(soft::StateHash(world), recording);
}

}  // namespace

void RunSoft(const plan::Run& run, protocol::Recording& recording) {
  protocol::RecordingHeader& header = recording.header();
  probes::BeginHeap();
  try {
    const std::int64_t place_begin = world::Now();
    layouts::InitialState state = layouts::DrawObjects(run.scene);
    header.scalars.fill_fraction = state.fill_fraction;
    layouts::Place(run.scene, state);
    if (run.scene.role == plan::Role::kTwin) layouts::Displace(run.scene, state);
    probes::BeginPeak();
    const std::int64_t build_begin = world::Now();
    header.scalars.place_ns = static_cast<double>(build_begin - place_begin);
    soft::SoftWorld world(run.scene, std::move(state));
    header.scalars.build_ns = static_cast<double>(world::Now() - build_begin);
    header.decisions = analysis::DecisionsText(analysis::AnalysePruning(run.scene));
    const bool is_measured = run.scene.role == plan::Role::kMeasured;
    if (is_measured) {
      header.scalars.harness_ns = StampsNs(run.scene);
      RunCycles(run.scene, world, recording);
    } else {
      RunWithoutClock(run.scene, world, recording);
      header.cycles_done.store(run.scene.world.Count("cycles"), std::memory_order_release);
    }
    header.state_hash = soft::StateHash(world);
    header.scalars.peak_rss_bytes = probes::PeakRssBytes();
    if (is_measured && analysis::SamplingOf(run.scene)) RunAgain(run.scene, world, recording);
    header.outcome.store(protocol::WorkerOutcome::kDone, std::memory_order_release);
  } catch (const std::bad_alloc&) {
    header.is_out_of_memory.store(1, std::memory_order_relaxed);
    ReportFailure(recording,
                  std::string(protocol::kOutOfMemory) + "; fewer nodes or fewer cycles need less");
  } catch (const std::exception& error) {
    ReportFailure(recording, error.what());
  }
}

}  // namespace cdb::worker
