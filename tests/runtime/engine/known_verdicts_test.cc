// Verdicts of scenes with known outcomes: the number of unsound ones judged stable, and of sound
// ones judged unstable.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>

#include "runtime/protocol/verdict.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/runtime/engine/known_scenes.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using protocol::Verdict;

struct OutcomeCounts {
  std::array<std::array<int, 2>, 2> runs = {};  ///< by outcome and verdict: sound, stable
  int Total(bool is_sound) const { return runs[is_sound][0] + runs[is_sound][1]; }
};

TEST(KnownScenes, VerdictsFindTheUnsoundAndAreSilentOnTheSound) {
  std::array<OutcomeCounts, std::size(kFaultNames)> counts;
  std::string surprises;
  Sample sample;
  for (const KnownScene& known : KnownScenes()) {
    if (!sample.Takes(std::string(known.family))) continue;
    const Recorded run = RunHere(known.scene);
    EXPECT_TRUE(run.done()) << known.family << ", " << known.variant << ": " << run.message();
    const protocol::Judgement judged =
        Judge(known.scene, run.recording, run.header().cycles_done.load());
    const bool is_stable = judged.verdict == Verdict::kStable;
    ++counts[static_cast<std::size_t>(known.fault)].runs[known.is_sound][is_stable];
    if (is_stable != known.is_sound)
      surprises +=
          fmt::format("  {}, {}: {} from cycle {} on, though {}\n", known.family, known.variant,
                      protocol::VerdictName(judged.verdict), judged.first_bad_cycle, known.why);
  }
  std::string table = fmt::format("{:20} {:>24} {:>24}\n", world::EnginePrecision(),
                                  "unsound: found, stable", "sound: stable, not");
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const auto& [unsound, sound] = counts[i].runs;
    table += fmt::format("{:20} {:17} {:6} {:17} {:6}\n", kFaultNames[i], unsound[0], unsound[1],
                         sound[1], sound[0]);
    EXPECT_GE(counts[i].Total(false), kAddressSanitizer ? 1 : 20) << kFaultNames[i];
    EXPECT_EQ(unsound[1], 0) << kFaultNames[i];
    EXPECT_EQ(sound[0], 0) << kFaultNames[i];
  }
  std::printf("%s%s", table.c_str(), surprises.c_str());
}

}  // namespace
}  // namespace cdb::tests
