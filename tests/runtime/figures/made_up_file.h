// Results files with made-up times, verdicts and omissions, for tests of summaries.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "runtime/results/store.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/support/files.h"

namespace cdb::tests {

/// The time of every phase in every cycle, ns; and other values.
struct MadeUp {
  double ns = 1000;
  protocol::Verdict verdict = protocol::Verdict::kStable;
  std::int64_t first_bad_cycle = 3;  ///< of an unsound run
  std::string omitted = {}, decisions = {};
  double stall = 0;                           ///< added to the first cycle
  double peak_rss = 5e6;                      ///< bytes
  std::map<std::string, double> errors = {};  ///< of the metrics that the plan asks for
  results::Status status = results::Status::kDone;
  std::int64_t bad_objects = -1;
  double moving_objects = NAN, mean_asleep = NAN;
  std::uint64_t cycles = 4;  ///< that were executed; all of them, unless the run failed
  machine::Noise noise = machine::Noise::kUnknown;
  std::string state = {};  ///< the hash of the last state
};
using MakeUp = std::function<MadeUp(const plan::Run&)>;

/// Ends a conclusion that made-up runs are stable, since their plans record no stability.
inline const std::string kNothingChecked =
    " Not checked: energy, losses, passing, impacts, sleep (record lacks stability).";

/// Cycles of each run.
inline constexpr std::uint64_t kMadeUpCycles = 4;

/// Writes a run. The plan records only timing.
inline void WriteMadeUp(const plan::Plan& plan, const plan::Run& run, const MadeUp& made,
                        const std::filesystem::path& folder) {
  FakeResult fake(run, made.status, made.cycles);
  std::vector<double> durations(protocol::kPhaseCount * kMadeUpCycles, made.ns);
  for (std::size_t phase = 0; phase < protocol::kPhaseCount; ++phase)
    durations[phase * kMadeUpCycles] += made.stall;
  fake.result.series = {{protocol::FindSeries("duration"), std::as_bytes(std::span(durations))}};
  fake.result.judgement.verdict = made.verdict;
  fake.result.judgement.first_bad_cycle =
      made.verdict <= protocol::Verdict::kStable ? -1 : made.first_bad_cycle;
  fake.result.judgement.bad_objects = made.bad_objects;
  fake.result.scalars.moving_objects = made.moving_objects;
  fake.result.scalars.mean_asleep = made.mean_asleep;
  fake.result.noise.noise = made.noise;
  fake.result.state_hash = made.state;
  fake.result.message = made.status == results::Status::kDone ? "" : "made up";
  fake.result.omitted = made.omitted;
  fake.result.decisions = made.decisions;
  fake.result.scalars.harness_ns = NAN;
  fake.result.scalars.peak_rss_bytes = made.peak_rss;
  if (!plan.references.empty()) {
    fake.result.errors.values["timestep"] = {0.001};
    fake.result.errors.values["position"] = {0.5};
    fake.result.errors.values["position_floor"] = {0};
    for (const auto& [name, value] : made.errors) fake.result.errors.values[name] = {value};
  }
  WriteRun(plan, run, fake.result, {{"build_type", "Release"}}, folder);
}

/// Returns `use(file)` for the merged file. Runs with the status `missing` are not in it.
template <typename Use>
auto WithMadeUpFile(const plan::Plan& plan, const MakeUp& make_up, Use use) {
  const TemporaryFolder folder;
  for (const plan::Run& run : plan.runs)
    if (const MadeUp made = make_up(run); made.status != results::Status::kMissing)
      WriteMadeUp(plan, run, made, folder.path());
  journal::Merge(plan, {{"build_type", "Release"}}, folder.path(), folder / "out.h5");
  return use(results::ResultFile(folder / "out.h5"));
}

}  // namespace cdb::tests
