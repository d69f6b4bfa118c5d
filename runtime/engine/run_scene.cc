#include "runtime/engine/run_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>

#include "compiler/reference.h"
#include "library/layouts/initial_state.h"
#include "library/layouts/nudge.h"
#include "library/layouts/placement.h"
#include "library/objects/solid_maker.h"
#include "runtime/engine/harness.h"
#include "runtime/engine/memory.h"
#include "runtime/engine/pair_referee.h"
#include "runtime/engine/probes.h"
#include "runtime/engine/sampler.h"
#include "runtime/engine/schedules.h"
#include "runtime/engine/settle.h"
#include "runtime/engine/state_hash.h"

namespace cdb::runtime {
namespace {

template <std::size_t size>
void CopyText(const std::string& text, char (&to)[size]) {
  const std::size_t length = std::min(text.size(), size - 1);
  std::memcpy(to, text.data(), length);
  to[length] = '\0';
}

/// One cycle after the other, with what belongs to each.
class Stepper {
 public:
  Stepper(const compiler::Scene& scene, Engine& engine)
      : engine_(engine), schedules_(scene, engine), tripwire_(engine) {}

  void Step() {
    schedules_.BeforeStep(steps_++);
    tripwire_.BeforeStep();
    engine_.Step();
    tripwire_.AfterStep();
  }

 private:
  Engine& engine_;
  Schedules schedules_;
  Tripwire tripwire_;
  std::uint64_t steps_ = 0;
};

bool RecordsPairs(const compiler::Scene& scene) { return scene.world.Lists("record", "pairs"); }

/// Times and memory are of a run that nobody referees.
bool WantsSecondPass(const compiler::Scene& scene) {
  return compiler::SamplingOf(scene) ||
         (RecordsPairs(scene) &&
          (scene.world.Lists("record", "timing") || scene.world.Lists("record", "memory")));
}

void RunCycles(const compiler::Scene& scene, Engine& engine, Recording& recording,
               int contacts_fd) {
  Probes probes(scene, engine, recording, contacts_fd);
  std::optional<PairReferee> referee;
  if (RecordsPairs(scene) && !WantsSecondPass(scene)) referee.emplace(engine, recording);
  const std::uint64_t warmup = scene.world.Count("warmup");
  const std::uint64_t cycles = scene.world.Count("cycles");
  Stepper stepper(scene, engine);
  for (std::uint64_t i = 0; i < warmup; ++i) stepper.Step();
  probes.Begin();
  for (std::uint64_t cycle = 0; cycle < cycles; ++cycle) {
    if (referee) referee->BeforeStep();
    stepper.Step();
    probes.Record(cycle);
    if (referee) referee->AfterStep(cycle);
    recording.header().cycles_done.store(cycle + 1, std::memory_order_release);
  }
}

/// All of it once, in a world that nobody has stepped yet, for samples and for the referee.
void RunWithoutClock(const compiler::Scene& scene, Engine& engine, Recording& recording) {
  std::optional<Sampler> sampler;
  if (compiler::SamplingOf(scene)) sampler.emplace(scene, engine, recording);
  std::optional<PairReferee> referee;
  if (RecordsPairs(scene)) referee.emplace(engine, recording);
  Stepper stepper(scene, engine);
  const std::uint64_t warmup = scene.world.Count("warmup");
  const std::uint64_t steps = warmup + scene.world.Count("cycles");
  if (sampler) sampler->Begin();
  for (std::uint64_t i = 0; i < steps; ++i) {
    if (sampler) sampler->BeforeStep();
    if (referee && i >= warmup) referee->BeforeStep();
    stepper.Step();
    if (sampler) sampler->AfterStep();
    if (referee && i >= warmup) referee->AfterStep(i - warmup);
  }
}

/// The same run once more without a clock, from the start, for what is held against the truth
/// alone. It has to go the same way.
void RunAgain(const compiler::Scene& scene, const Engine& first, Recording& recording) {
  compiler::Scene quiet = scene;
  quiet.world.values.insert_or_assign("record", compiler::WordList{});
  Engine engine(quiet, first.initial_state(), first.omissions());
  RunWithoutClock(scene, engine, recording);
  const std::string hash = StateHash(engine);
  if (hash != recording.header().state_hash)
    throw std::runtime_error(
        fmt::format("the pass that looks for errors ended in the state {} and the timed one in {}: "
                    "this run does not repeat itself, and neither pass can be trusted",
                    hash, recording.header().state_hash));
}

}  // namespace

void ReportFailure(Recording& recording, const std::string& message) {
  CopyText(message, recording.header().message);
  recording.header().outcome.store(WorkerOutcome::kFailed, std::memory_order_release);
}

std::unique_ptr<Engine> RunScene(const compiler::Run& run, Recording& recording, int contacts_fd,
                                 const std::string& keep_walls) {
  RecordingHeader& header = recording.header();
  std::unique_ptr<Engine> engine;
  try {
    const std::int64_t place_begin = Now();
    library::InitialState state = library::DrawObjects(run.scene);
    header.fill_fraction = state.fill_fraction;  // known also where placing fails
    CopyText(library::FormsText(state.forms), header.models);
    library::Place(run.scene, state);
    if (HasPile(run.scene)) SettlePiles(run.scene, state);
    if (run.scene.role == compiler::Role::kTwin) library::Nudge(run.scene, state);
    const std::int64_t build_begin = Now();
    header.place_ns = static_cast<double>(build_begin - place_begin);
    Omissions omissions = SettleNeeds(run.scene, state);
    if (!keep_walls.empty()) omissions.Keep(compiler::Component::kWalls, keep_walls);
    engine = std::make_unique<Engine>(run.scene, std::move(state), std::move(omissions));
    header.build_ns = static_cast<double>(Now() - build_begin);
    CopyText(compiler::OmittedNames(engine->omissions().needs), header.omitted);
    CopyText(compiler::NeedsText(engine->omissions().needs), header.needs);
    if (run.scene.role == compiler::Role::kMeasured) {
      header.harness_ns = HarnessNs(run.scene, *engine);
      RunCycles(run.scene, *engine, recording, contacts_fd);
    } else {
      RunWithoutClock(run.scene, *engine, recording);
      header.cycles_done.store(run.scene.world.Count("cycles"), std::memory_order_release);
    }
    CopyText(StateHash(*engine), header.state_hash);
    header.peak_rss_bytes = PeakRssBytes();
    if (run.scene.role == compiler::Role::kMeasured && WantsSecondPass(run.scene))
      RunAgain(run.scene, *engine, recording);
    header.outcome.store(WorkerOutcome::kDone, std::memory_order_release);
  } catch (const Tripped& tripped) {
    if (HowAsked(run.scene, compiler::Component::kWalls) == compiler::Asked::kAuto) throw;
    ReportFailure(recording, fmt::format("omit walls: this scene needs them: {}", tripped.what()));
  } catch (const std::bad_alloc&) {
    ReportFailure(recording, "out of memory; fewer objects or fewer cycles need less");
  } catch (const std::exception& error) {
    ReportFailure(recording, error.what());
  }
  return engine;
}

}  // namespace cdb::runtime
