#include "runtime/engine/worker/run_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "compiler/analysis/queries.h"
#include "compiler/analysis/recorded.h"
#include "compiler/analysis/reference.h"
#include "compiler/yaml/plan_yaml.h"
#include "library/confinement.h"
#include "library/layouts/initial_state.h"
#include "library/layouts/placement.h"
#include "library/objects/solid_factory.h"
#include "runtime/engine/detection/detectors.h"
#include "runtime/engine/probes/pair_referee.h"
#include "runtime/engine/probes/probes.h"
#include "runtime/engine/probes/processor_time.h"
#include "runtime/engine/probes/sampler.h"
#include "runtime/engine/probes/state_hash.h"
#include "runtime/engine/scene_queries/queries.h"
#include "runtime/engine/worker/narrow_input.h"
#include "runtime/engine/worker/settle.h"
#include "runtime/engine/world/engine.h"

namespace cdb::worker {
namespace {

/// Executes one cycle after the other, with the probes and schedules around each.
class Stepper {
 public:
  Stepper(const plan::Scene& scene, world::Engine& engine)
      : engine_(engine), schedules_(scene, engine), kinematics_(scene, engine), guard_(engine) {}

  void Step() {
    engine_.Change();  // before the bodies are pushed
    schedules_.BeforeStep(steps_);
    kinematics_.BeforeStep(steps_);
    guard_.BeforeStep();
    engine_.Step();
    kinematics_.AfterStep(steps_++);
    guard_.AfterStep();
  }

 private:
  world::Engine& engine_;
  world::Schedules schedules_;
  world::Kinematics kinematics_;
  world::OmissionGuard guard_;
  std::uint64_t steps_ = 0;
};

bool RecordsPairs(const plan::Scene& scene) { return scene.world.Lists("record", "pairs"); }
bool ComparesQueries(const plan::Scene& scene) {
  return analysis::HasQueries(scene) && scene.world.Lists("record", "query_errors");
}

/// Times and memory are measured without the referees.
bool WantsSecondPass(const plan::Scene& scene) {
  return analysis::SamplingOf(scene) ||
         ((RecordsPairs(scene) || ComparesQueries(scene)) &&
          (analysis::MeasuresPhases(scene) || scene.world.Lists("record", "memory")));
}

void RunCycles(const plan::Scene& scene, world::Engine& engine, protocol::Recording& recording,
               Streams streams) {
  probes::Probes probes(scene, engine, recording, streams.contacts_fd);
  std::optional<NarrowInput> narrow_input;
  if (streams.narrow_input_fd >= 0) narrow_input.emplace(engine, streams.narrow_input_fd);
  std::optional<probes::PairReferee> referee;
  if (RecordsPairs(scene) && !WantsSecondPass(scene)) referee.emplace(engine, recording);
  std::optional<scene_queries::Queries> queries;
  if (analysis::HasQueries(scene)) queries.emplace(scene, engine, recording);
  std::optional<scene_queries::QueryReferee> query_referee;
  if (ComparesQueries(scene) && !WantsSecondPass(scene)) query_referee.emplace(engine, recording);
  const std::uint64_t warmup = scene.world.Count("warmup");
  const std::uint64_t cycles = scene.world.Count("cycles");
  Stepper stepper(scene, engine);
  for (std::uint64_t i = 0; i < warmup; ++i) stepper.Step();
  if (narrow_input) narrow_input->Begin();
  probes.Begin();
  const probes::ProcessorTime processor_time;
  for (std::uint64_t cycle = 0; cycle < cycles; ++cycle) {
    engine.Change();
    if (referee) referee->BeforeStep();
    stepper.Step();
    if (queries) queries->Ask(cycle);
    probes.Record(cycle);
    if (queries) queries->Record(cycle);
    if (query_referee) query_referee->Compare(*queries, cycle);
    if (referee) referee->AfterStep(cycle);
    recording.header().cycles_done.store(cycle + 1, std::memory_order_release);
  }
  processor_time.Store(recording.header().scalars);
}

/// Runs all cycles without a clock, for samples, for the pair referee, and for the verdict of a
/// reference run.
void RunWithoutClock(const plan::Scene& scene, world::Engine& engine,
                     protocol::Recording& recording) {
  std::optional<probes::Sampler> sampler;
  if (analysis::SamplingOf(scene)) sampler.emplace(scene, engine, recording);
  std::optional<probes::PairReferee> referee;
  if (RecordsPairs(scene)) referee.emplace(engine, recording);
  std::optional<probes::Probes> probes;
  if (scene.role == plan::Role::kReference) probes.emplace(scene, engine, recording, -1);
  std::optional<scene_queries::Queries> queries;
  std::optional<scene_queries::QueryReferee> query_referee;
  if (ComparesQueries(scene)) {
    queries.emplace(scene, engine, recording);
    query_referee.emplace(engine, recording);
  }
  Stepper stepper(scene, engine);
  const std::uint64_t warmup = scene.world.Count("warmup");
  const std::uint64_t steps = warmup + scene.world.Count("cycles");
  if (sampler) sampler->Begin();
  if (probes) probes->Begin();
  for (std::uint64_t i = 0; i < steps; ++i) {
    engine.Change();
    if (sampler) sampler->BeforeStep();
    if (referee && i >= warmup) referee->BeforeStep();
    stepper.Step();
    if (sampler) sampler->AfterStep();
    if (referee && i >= warmup) referee->AfterStep(i - warmup);
    if (queries && i >= warmup) {
      queries->Ask(i - warmup);
      query_referee->Compare(*queries, i - warmup);
    }
    if (probes) probes->Record(i);
  }
}

/// Runs the same scene again from the start without a clock, for the measurements that are compared
/// with the truth. Its motion must be the same.
void RunAgain(const plan::Scene& scene, const world::Engine& first,
              protocol::Recording& recording) {
  plan::Scene quiet = scene;
  quiet.world.Set("record", schema::WordList{});
  world::Engine engine(quiet, first.initial_state(), first.omissions());
  RunWithoutClock(scene, engine, recording);
  RequireSameState(probes::StateHash(engine), recording);
}

/// Reports progress to the runner, and keeps the time spent on settling.
void SettleAndTell(const plan::Scene& scene, layouts::InitialState& state,
                   protocol::Settling& told) {
  std::int64_t begin = -1;
  SettlePiles(scene, state, [&](const SettlingProgress& progress) {
    if (progress.phase == protocol::SettlingPhase::kSettling && begin < 0) begin = world::Now();
    told.at_rest.store(progress.at_rest, std::memory_order_relaxed);
    told.objects.store(progress.objects, std::memory_order_relaxed);
    told.phase.store(progress.phase, std::memory_order_relaxed);
  });
  if (begin >= 0) told.seconds.store(static_cast<double>(world::Now() - begin) * 1e-9);
  told.phase.store(protocol::SettlingPhase::kNone);
}

}  // namespace

void ReportFailure(protocol::Recording& recording, const std::string& message) {
  recording.header().message = message;
  recording.header().outcome.store(protocol::WorkerOutcome::kFailed, std::memory_order_release);
}

void RequireSameState(const std::string& hash, protocol::Recording& recording) {
  const std::string timed = recording.header().state_hash.str();
  if (hash != timed)
    throw std::runtime_error(
        fmt::format("the pass that measures errors ended in the state {}, the timed pass in {}: "
                    "this run is not repeatable, and neither pass can be trusted",
                    hash, timed));
}

std::unique_ptr<world::Engine> RunScene(const plan::Run& run, protocol::Recording& recording,
                                        Streams streams, const Kept& kept) {
  protocol::RecordingHeader& header = recording.header();
  std::unique_ptr<world::Engine> engine;
  probes::BeginHeap();
  try {
    const std::int64_t place_begin = world::Now();
    layouts::InitialState state = layouts::DrawObjects(run.scene);
    header.scalars.fill_fraction = state.fill_fraction;  // known even if placing fails
    header.models = objects::ModelsText(state.forms);
    layouts::Place(run.scene, state);
    if (yaml::HasPile(run.scene)) SettleAndTell(run.scene, state, header.settling);
    if (run.scene.role == plan::Role::kTwin) layouts::Displace(run.scene, state);
    probes::BeginPeak();
    const std::int64_t build_begin = world::Now();
    header.scalars.place_ns = static_cast<double>(build_begin - place_begin);
    omissions::Omissions omissions = omissions::DecideOmissions(run.scene, state);
    for (const schema::ComponentInfo& info : schema::Components())
      if (omissions.Omits(info.component) && schema::ListsWord(kept.names, info.name))
        omissions.Keep(info.component, kept.why);
    if (!run.scene.plugins.empty())
      library::Confine();  // after caches are written and before plug-ins are loaded
    engine = std::make_unique<world::Engine>(run.scene, std::move(state), std::move(omissions));
    header.scalars.build_ns = static_cast<double>(world::Now() - build_begin);
    header.omitted = analysis::OmittedNames(engine->omissions().decisions);
    header.decisions = analysis::DecisionsText(engine->omissions().decisions);
    if (run.scene.role == plan::Role::kMeasured) {
      header.scalars.harness_ns = HarnessNs(run.scene, *engine);
      RunCycles(run.scene, *engine, recording, streams);
    } else {
      RunWithoutClock(run.scene, *engine, recording);
      header.cycles_done.store(run.scene.world.Count("cycles"), std::memory_order_release);
    }
    header.state_hash = probes::StateHash(*engine);
    header.scalars.peak_rss_bytes = probes::PeakRssBytes();
    if (run.scene.role == plan::Role::kMeasured && WantsSecondPass(run.scene))
      RunAgain(run.scene, *engine, recording);
    header.outcome.store(protocol::WorkerOutcome::kDone, std::memory_order_release);
  } catch (const world::OmissionGuardTripped& tripped) {
    if (analysis::RequestFor(run.scene, schema::Component::kWalls) ==
        analysis::PruningRequest::kAuto)
      throw;
    ReportFailure(recording, fmt::format("omit walls: this scene needs them: {}", tripped.what()));
  } catch (const std::bad_alloc&) {
    header.is_out_of_memory.store(1, std::memory_order_relaxed);  // also if the settling worker ran
                                                                  // out of memory
    ReportFailure(recording, std::string(protocol::kOutOfMemory) +
                                 "; fewer objects or fewer cycles need less");
  } catch (const std::exception& error) {
    ReportFailure(recording, error.what());
  }
  return engine;
}

double HarnessNs(const plan::Scene& scene, const world::Engine& engine) {
  const detection::NamedDetector idle = detection::MakeDetector("null", scene);
  Scene bodies = {};
  bodies.size = engine.objects().size() + engine.walls().size();
  std::vector<Pair> pairs;
  std::vector<Contact> contacts;
  std::array<world::Stamp, world::TimedWorld::kStamps> stamps = {};
  return MedianNs([&] {
    for (world::Stamp& stamp : stamps) stamp = world::TakeStamp();
    idle.detector->FindPairs(bodies, pairs);
    idle.detector->FindContacts(bodies, pairs, contacts);
  });
}

}  // namespace cdb::worker
