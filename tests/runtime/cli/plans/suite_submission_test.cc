// `cdb suite --check` of complete submissions with made-up results.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/runtime/cli/plans/submission.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

plans::SuiteChoice WithDetector(const std::string& name) {
  plans::SuiteChoice choice;
  choice.detectors = {name};
  return choice;
}
plans::SuiteChoice WithSeed(std::uint64_t seed) {
  plans::SuiteChoice choice;
  choice.seed = seed;
  return choice;
}

TEST(SuiteCheck, AcceptsACompleteSubmissionAndNamesWhatSpoilsIt) {
  if (kAnySanitizer) GTEST_SKIP() << "it writes and reads 420 runs";
  const Submission of;
  of.Write("games/debris", {}, kSuiteProvenance, WithDetector("simple"));  // no fault
  of.Summarise();
  EXPECT_EQ(of.Faults(), std::vector<std::string>{});

  results::Provenance other = kSuiteProvenance;
  other["build_type"] = "Debug";
  other["jobs"] = "2";
  other["commit"] = "dec0de";
  of.Write("stiff/stack", {}, other);
  of.Write("stiff/bounce", [](const plan::Run& run, SuiteRun& made) {
    if (run.at[0] == 1 && run.rep == 4) made.status = results::Status::kMissing;
  });
  of.Write("stiff/pendulum", [](const plan::Run& run, SuiteRun& made) {
    if (run.at[0] == 1 && run.rep < 3) made.noise = machine::Noise::kNoisy;
  });
  of.Write("granular/drum", {}, kSuiteProvenance, WithSeed(7));
  std::filesystem::copy_file(of.File("robotics/bin"), of.File("robotics/warehouse"),
                             std::filesystem::copy_options::overwrite_existing);
  const std::vector<std::string> faults = of.Faults();
  for (const char* part :
       {"stiff/stack: timed with a Debug build", "stiff/stack: 2 runs were executed in parallel",
        "the scenes are not of one run of the suite: commit is ", "stiff/bounce: 1 run",
        "stiff/pendulum iterations_50", "granular/drum: it is not of version",
        "robotics/warehouse: it is not of version",
        "suite.json: it is not the summary of these results"})
    EXPECT_EQ(std::ranges::count_if(
                  faults,
                  [&](const std::string& fault) { return fault.find(part) != std::string::npos; }),
              1)
        << part << " is not in\n"
        << fmt::format("{}", fmt::join(faults, "\n"));
}

}  // namespace
}  // namespace cdb::tests
