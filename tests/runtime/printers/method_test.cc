// The sentences on the method of a measurement (`cdb show --method`).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "runtime/figures/model.h"
#include "runtime/printers/document.h"
#include "runtime/printers/show.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

using testing::HasSubstr;

results::Provenance FactsOfAMachine() {
  return {{"host", "h"},
          {"cpu", "Fast 9000"},
          {"cpus", "8"},
          {"memory", "16000000 kB"},
          {"cpu_base_clock", "2100000 kHz"},
          {"cpu_max_clock", "4500000 kHz"},
          {"cpu_governor", "performance"},
          {"system", "Debian GNU/Linux 12 (bookworm)"},
          {"kernel", "Linux 6.1.0 x86_64"},
          {"jobs", "1"},
          {"bullet_version", "3.24"},
          {"cdb_version", "0.1.0"},
          {"commit", "0123456789ab"},
          {"build_type", "Release"},
          {"compiler", "GNU 12.2.0"},
          {"compiler_flags", " -O3 -DNDEBUG"}};
}

plan::Plan MethodPlan(std::uint64_t repeats) {
  return MakePlan({NumberAxis("n", {1, 2}), TextAxis("detector", {"sap", "dbvt"})}, repeats,
                  {.cycles = 4, .record = {"timing"}});
}

/// `facts_of` a run, by its index.
template <typename FactsOf>
std::string MethodText(const plan::Plan& plan, FactsOf facts_of,
                       printers::Format format = printers::Format::kTerminal) {
  const TemporaryFolder folder;
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    FakeResult fake(plan.runs[i]);
    fake.result.omitted = plan.runs[i].at[1] == 0 ? "raycast_tree gravity" : "walls raycast_tree";
    WriteRun(plan, plan.runs[i], fake.result, facts_of(i), folder.path());
  }
  journal::Merge(plan, {}, folder.path(), folder / "out.h5");
  std::string text = printers::ShowMethod(results::ResultFile(folder / "out.h5"), format).text;
  std::ranges::replace(text, '\n', ' ');
  return text;
}

TEST(Method, StatesMachineSoftwareProcedureAndStatistic) {
  EXPECT_EQ(
      MethodText(MethodPlan(5), [](std::size_t) { return FactsOfAMachine(); }),
      "All 20 runs were executed on one machine (Fast 9000, 8 logical processors, base clock 2.10 "
      "GHz, maximum clock 4.50 GHz, frequency governor performance, 16.4 GB of memory) under "
      "Debian GNU/Linux 12 (bookworm) with kernel Linux 6.1.0 x86_64. They used Bullet 3.24 in "
      "single precision, run by cdb 0.1.0 (commit 0123456789ab, compiled by GCC 12.2.0 with -O3 "
      "-DNDEBUG). Omitted, because the scene does not need them: pairs of a wall and an object "
      "that cannot reach it (in 2 of 4 configurations); the tree for ray casts that Bullet keeps "
      "beside sap and sap32. Each of the 4 configurations was run 5 times for 4 steps, each time "
      "in a separate process, one run at a time; all were run once before any was repeated, with "
      "the detectors in random order. The time of each step is its median over the repeats, and "
      "the time of a configuration is the mean over its steps; intervals are 95 % confidence "
      "intervals by the bootstrap over whole runs (expanded percentiles after Hesterberg 2015, "
      "outliers winsorised). ");
}

TEST(Method, StatesWhatAllMachinesShare) {
  const std::string text = MethodText(MethodPlan(2), [](std::size_t i) {
    results::Provenance facts = FactsOfAMachine();
    facts["host"] = i % 2 == 0 ? "h" : "g";
    facts["cpu"] = i % 2 == 0 ? "Fast 9000" : "Slow 1";
    facts["jobs"] = "4";
    facts["build_type"] = "Debug";
    return facts;
  });
  EXPECT_THAT(text, HasSubstr("on 2 machines (Fast 9000; Slow 1) under Debian"));
  EXPECT_THAT(text, HasSubstr("build type Debug"));
  EXPECT_THAT(text, HasSubstr("up to 4 runs in parallel"));
  EXPECT_THAT(text, HasSubstr("too few for a confidence interval"));
}

TEST(Method, DoesWithoutFactsThatTheFileLacks) {
  const std::string text =
      MethodText(MethodPlan(1), [](std::size_t) { return results::Provenance(); });
  EXPECT_THAT(text, HasSubstr("All 4 runs were executed on one machine. They used Bullet in single "
                              "precision, run by cdb."));
  EXPECT_THAT(text, HasSubstr("without intervals."));
}

TEST(Method, EscapesWhatLatexWouldRead) {
  const std::string text = MethodText(
      MethodPlan(5), [](std::size_t) { return FactsOfAMachine(); }, printers::Format::kLatex);
  EXPECT_THAT(text, HasSubstr("95 \\%"));
  EXPECT_THAT(text, HasSubstr("x86\\_64"));
}

}  // namespace
}  // namespace cdb::tests
