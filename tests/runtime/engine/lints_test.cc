// What the lints foretell is what runs come to.
#include "compiler/lints.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <string>

#include "runtime/measure/verdict.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/runtime/engine/random_scenes.h"

namespace cdb::test {
namespace {

constexpr std::size_t kScenes = 1700;
constexpr std::uint64_t kSeed = 1;
constexpr double kAgreement = 0.95;

/// What the lints say of a scene, by its worst number.
enum Forecast { kSound, kDoubtful, kBad };

Forecast ForecastOf(const std::vector<compiler::LintNumber>& numbers) {
  if (std::ranges::any_of(numbers, &compiler::LintNumber::IsBad)) return kBad;
  return std::ranges::any_of(numbers, &compiler::LintNumber::IsDoubtful) ? kDoubtful : kSound;
}

/// Runs by forecast and by whether they were stable.
struct Confusion {
  std::array<std::array<int, 2>, 3> runs = {};
  double Agreement(Forecast forecast, bool stable) const {
    const auto& row = runs[forecast];
    return static_cast<double>(row[stable]) / (row[0] + row[1]);
  }
};

TEST(Lints, ForetellTheVerdictsOfRandomScenes) {
  Confusion all;
  std::map<std::string_view, Confusion> themes;
  int failed = 0;
  std::string surprises;
  for (const RandomScene& random : RandomScenes(kScenes, kSeed)) {
    const Recorded recorded = RunHere(random.scene);
    if (!recorded.done()) {
      ++failed;  // out of the precision's reach: said when it is placed or built
      continue;
    }
    const runtime::Judgement judged =
        runtime::Judge(random.scene, recorded.recording, recorded.header().cycles_done.load());
    ASSERT_NE(judged.verdict, runtime::Verdict::kUnknown);
    const bool stable = judged.verdict == runtime::Verdict::kStable;
    const auto numbers = compiler::LintScene(random.scene);
    const Forecast forecast = ForecastOf(numbers);
    ++all.runs[forecast][stable];
    ++themes[random.theme].runs[forecast][stable];
    if (forecast == kDoubtful || stable == (forecast == kSound)) continue;
    surprises += fmt::format("  {}: {} at {}:", random.theme, VerdictName(judged.verdict),
                             judged.first_bad_cycle);
    for (const compiler::LintNumber& number : numbers)
      if (number.Severity() > 0.1)
        surprises += fmt::format(" {} {:.2g}", InfoOf(number.lint).kind.id, number.Severity());
    surprises += "\n";
  }
  std::string table =
      fmt::format("{:14} {:>22} {:>22} {:>22}\n", runtime::EnginePrecision(), "sound: stable, not",
                  "doubtful: stable, not", "bad: stable, not");
  const auto add = [&table](std::string_view name, const Confusion& confusion) {
    table += fmt::format("{:14}", name);
    for (const auto& row : confusion.runs) table += fmt::format(" {:16} {:5}", row[1], row[0]);
    table += "\n";
  };
  for (const auto& [name, confusion] : themes) add(name, confusion);
  add("all", all);
  std::printf("%s%d of %zu failed to begin\nsurprises, with numbers over their limits:\n%s",
              table.c_str(), failed, kScenes, surprises.c_str());
  EXPECT_LT(failed, static_cast<int>(kScenes / 20));
  EXPECT_GE(all.Agreement(kSound, true), kAgreement);
  EXPECT_GE(all.Agreement(kBad, false), kAgreement);
}

}  // namespace
}  // namespace cdb::test
