#include "tests/runtime/figures/suite_results.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <span>
#include <stdexcept>

#include "compiler/compile.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/support/compile_text.h"
#include "tests/support/files.h"

namespace cdb::tests {

plan::Plan SuitePlan(const std::vector<std::string>& detectors, std::uint64_t repeats) {
  const compiler::Compilation compiled = CompileText(
      fmt::format("benchmark fixture \"A scene\" {{\n  cycles 4\n  repeats {}\n  timestep 1 / 60\n"
                  "  accuracy {{ metrics position }}\n  world.side 1000\n  detector sweep({})\n"
                  "  objects {{ quantity 10 }}\n}}\n",
                  repeats, fmt::join(detectors, ", ")));
  if (compiled.plans.size() != 1) throw std::runtime_error("the fixture has errors");
  return compiled.plans[0];
}

void WriteSuiteResults(const plan::Plan& plan, const std::string& error, const SuiteChange& change,
                       const std::filesystem::path& out, const results::Provenance& provenance) {
  const TemporaryFolder runs;
  auto journal = journal::Journal::OpenToWrite(runs.path(), plan.Sha256());
  journal::RunWriter writer(plan, provenance);
  for (const plan::Run& run : plan.runs) {
    SuiteRun made;
    change(run, made);
    if (made.status == results::Status::kMissing) continue;
    FakeResult fake(run, made.status, run.scene.world.Count("cycles"));
    const std::vector<double> durations(protocol::kPhaseCount * run.scene.world.Count("cycles"),
                                        made.ns);
    for (auto& [series, bytes] : fake.result.series)
      if (series->name == "duration") bytes = std::as_bytes(std::span(durations));
    fake.result.judgement.verdict = made.verdict;
    fake.result.judgement.first_bad_cycle = made.verdict == protocol::Verdict::kStable ? -1 : 3;
    fake.result.state_hash = made.state;
    fake.result.host = "here";
    fake.result.message = made.status == results::Status::kDone ? "" : "made up";
    fake.result.omitted = made.omitted;
    fake.result.decisions = made.omitted.empty() ? "solver: kept: a test\n" : "";
    fake.result.noise.noise = made.noise;
    fake.result.scalars.peak_rss_bytes = made.peak_bytes;
    fake.result.errors.values["timestep"] = {run.scene.world.Real("timestep")};
    fake.result.errors.values[error] = {made.error};
    writer.Write(run, fake.result, journal);
  }
  journal::Merge(plan, provenance, runs.path(), out);
}

}  // namespace cdb::tests
