#include "runtime/engine/run_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>
#include <string>

#include "library/layouts/initial_state.h"
#include "library/layouts/placement.h"
#include "library/objects/solid_maker.h"
#include "runtime/engine/probes.h"
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

void RunCycles(const compiler::Scene& scene, Engine& engine, Recording& recording,
               int contacts_fd) {
  Probes probes(scene, engine, recording, contacts_fd);
  const std::uint64_t warmup = scene.world.Count("warmup");
  const std::uint64_t cycles = scene.world.Count("cycles");
  Schedules schedules(scene, engine);
  Tripwire tripwire(engine);
  std::uint64_t steps = 0;
  const auto step = [&] {
    schedules.BeforeStep(steps++);
    tripwire.BeforeStep();
    engine.Step();
    tripwire.AfterStep();
  };
  for (std::uint64_t i = 0; i < warmup; ++i) step();
  probes.Begin();
  for (std::uint64_t cycle = 0; cycle < cycles; ++cycle) {
    step();
    probes.Record(cycle);
    recording.header().cycles_done.store(cycle + 1, std::memory_order_release);
  }
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
    const std::int64_t build_begin = Now();
    header.place_ns = static_cast<double>(build_begin - place_begin);
    Omissions omissions = SettleNeeds(run.scene, state);
    if (!keep_walls.empty()) omissions.Keep(compiler::Component::kWalls, keep_walls);
    engine = std::make_unique<Engine>(run.scene, std::move(state), std::move(omissions));
    header.build_ns = static_cast<double>(Now() - build_begin);
    CopyText(compiler::OmittedNames(engine->omissions().needs), header.omitted);
    CopyText(compiler::NeedsText(engine->omissions().needs), header.needs);
    RunCycles(run.scene, *engine, recording, contacts_fd);
    CopyText(StateHash(*engine), header.state_hash);
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

double PeakRssBytes() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kilobytes = 0;
    if (word == "VmHWM:" && status >> kilobytes) return kilobytes * 1024;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace cdb::runtime
