#include "tests/runtime/figures/compared_results.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <span>
#include <stdexcept>

#include "compiler/compile.h"
#include "library/distributions/stream.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {

plan::Plan ComparedPlan(std::uint64_t repeats, const std::vector<std::string>& quantities,
                        const std::vector<std::string>& detectors, const std::string& more,
                        const std::string& record) {
  const std::string detector =
      detectors.empty() ? "" : fmt::format("detector sweep({})", fmt::join(detectors, ", "));
  const compiler::Compilation compiled = CompileText(
      fmt::format("benchmark fixture \"A comparison\" {{\n  cycles {}\n  repeats {}\n"
                  "  record {}\n  accuracy {{ metrics position }}\n  world.side 1000\n  {}\n"
                  "  {}\n  objects {{ quantity sweep({}) }}\n}}\n",
                  kComparedCycles, repeats, record, more, detector, fmt::join(quantities, ", ")));
  if (compiled.plans.size() != 1) throw std::runtime_error("the fixture has errors");
  return compiled.plans[0];
}

void WriteCompared(const ComparedResult& of, const std::filesystem::path& out) {
  const TemporaryFolder runs;
  distributions::Stream stream(of.seed);
  for (const plan::Run& run : of.plan.runs) {
    ComparedRun made;
    of.change(run, made);
    FakeResult fake(run);
    const std::uint64_t cycles = run.scene.world.Count("cycles");
    const double of_run = made.factor * std::exp(of.noise * stream.Normal());
    std::vector<double> durations;
    for (std::size_t phase = 0; phase < protocol::kPhaseCount; ++phase)
      for (std::size_t cycle = 0; cycle < cycles; ++cycle)
        durations.push_back(1000 * of_run * std::exp(of.noise * stream.Normal()));
    const std::vector<std::int32_t> zeros(cycles, 0), hundreds(cycles, 100),
        missed(cycles, made.missed);
    fake.result.series = {
        {protocol::FindSeries("duration"), std::as_bytes(std::span(durations))},
        {protocol::FindSeries("exact_pairs"), std::as_bytes(std::span(hundreds))},
        {protocol::FindSeries("missed_pairs"), std::as_bytes(std::span(missed))},
        {protocol::FindSeries("phantom_pairs"), std::as_bytes(std::span(zeros))},
        {protocol::FindSeries("duplicate_pairs"), std::as_bytes(std::span(zeros))}};
    fake.result.status = made.status;
    fake.result.judgement.verdict = made.verdict;
    fake.result.judgement.first_bad_cycle = made.verdict == protocol::Verdict::kStable ? -1 : 3;
    fake.result.state_hash = made.state;
    fake.result.omitted = made.omitted;
    fake.result.decisions = made.omitted.empty() ? "solver: kept: a test\n" : "";
    fake.result.message = "";
    fake.result.started_s = 1.7e9 + of.started + static_cast<double>(run.rep);
    fake.result.scalars.peak_rss_bytes = made.peak_bytes;
    fake.result.scalars.harness_ns = 40 * std::exp(of.noise * stream.Normal());
    fake.result.errors.values["position"] = {made.error};
    fake.result.errors.values["position_floor"] = {made.floor};
    WriteRun(of.plan, run, fake.result, of.provenance, runs.path());
  }
  journal::Merge(of.plan, of.provenance, runs.path(), out);
}

ComparedScene Slower(std::size_t detector, double factor) {
  return [=](const plan::Run& run, ComparedRun& made) {
    if (run.at[0] == detector) made.factor = factor;
  };
}

}  // namespace cdb::tests
