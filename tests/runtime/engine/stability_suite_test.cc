// The stability suite: the harmless end of each scenario is stable, and no hopeless end is.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "compiler/compile.h"
#include "dsl/diagnostics.h"
#include "runtime/protocol/verdict.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/support/folders.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using protocol::Verdict;

/// Configurations whose axis has no hopeless end, by benchmark and, if that is true only for some,
/// by the value on the other axis.
bool HasNoHopelessEnd(const std::string& benchmark, const std::string& other) {
  // Light objects on heavy ones are stable throughout the suite; continuous detection stops every
  // fast object.
  if (benchmark == "stability_light_on_heavy") return true;
  if (benchmark == "stability_speed" && other == "continuous") return true;
  // Double precision has enough digits for 10^9 m, and for thin cylinders.
  return !kIsSingle && (benchmark.starts_with("stability_far_") ||
                        (benchmark == "stability_thin_rods" && other == "cylinder"));
}

Verdict VerdictOf(plan::Scene scene) {
  SetWorld(scene, "precision", Word(world::EnginePrecision()));
  const Recorded run = RunHere(scene);
  EXPECT_TRUE(run.done()) << run.message();
  return Judge(scene, run.recording, scene.world.Count("cycles")).verdict;
}

TEST(StabilitySuite, HasSoundBeginningsAndNoSoundHopelessEnds) {
  std::size_t ends = 0;
  Sample sample;
  std::vector<std::string> files;
  for (const auto& entry :
       std::filesystem::directory_iterator(SourceFolder() / "library/scenarios/stability"))
    files.push_back(entry.path());
  std::ranges::sort(files);
  ASSERT_GE(files.size(), 15u);
  for (const std::string& file : files) {
    const auto result = compiler::Compile(file, compiler::ReadFromDisk,
                                          {SourceFolder() / "library/scenarios", std::nullopt});
    ASSERT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
    for (const plan::Plan& plan : result.plans) {
      std::size_t own = plan.axes.size();
      while (own-- > 0 && plan.axes[own].IsText()) continue;
      ASSERT_LT(own, plan.axes.size()) << plan.benchmark;
      for (const plan::Run& run : plan.runs) {
        const bool is_first = run.at[own] == 0;
        const bool is_last = run.at[own] + 1 == plan.axes[own].values.size();
        if (!is_first && !is_last) continue;
        if (!sample.Takes(is_first ? "first" : "last")) continue;
        std::string other;
        for (std::size_t axis = 0; axis < plan.axes.size(); ++axis)
          if (axis != own) other = std::get<std::string>(plan.axes[axis].values[run.at[axis]]);
        SCOPED_TRACE(Describe(plan, run));
        const Verdict verdict = VerdictOf(run.scene);
        ends += is_last ? 1 : 0;
        if (is_first) {
          EXPECT_EQ(verdict, Verdict::kStable)
              << plan.benchmark << ": " << protocol::VerdictName(verdict);
        } else if (!HasNoHopelessEnd(plan.benchmark, other)) {
          EXPECT_NE(verdict, Verdict::kStable) << plan.benchmark;
          EXPECT_NE(verdict, Verdict::kUnknown) << plan.benchmark;
        }
      }
    }
  }
  EXPECT_GE(ends, kAddressSanitizer ? 1u : 20u);
}

}  // namespace
}  // namespace cdb::tests
