// Lints predict the verdicts of runs.
#include "compiler/lints/lints.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <map>
#include <ranges>
#include <string>

#include "compiler/compile.h"
#include "runtime/protocol/verdict.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/runtime/engine/random_scenes.h"
#include "tests/support/folders.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

// The ordinary build compares the verdicts; sanitizers check the same code in fewer scenes.
constexpr std::size_t kScenes = kAddressSanitizer ? 300 : 1700;
constexpr std::size_t kMostSuiteRuns = kAddressSanitizer ? 3 : 1000;
constexpr std::uint64_t kSeed = 1;
constexpr double kAgreement = 0.95;

/// The prediction of the lints for a scene, by its worst number.
enum Prediction { kSound, kDoubtful, kBad };

Prediction PredictionOf(const std::vector<lints::LintNumber>& numbers) {
  if (std::ranges::any_of(numbers, &lints::LintNumber::IsBad)) return kBad;
  return std::ranges::any_of(numbers, &lints::LintNumber::IsDoubtful) ? kDoubtful : kSound;
}

/// Runs by prediction and by whether they were stable.
struct Confusion {
  std::array<std::array<int, 2>, 3> runs = {};
  double Agreement(Prediction prediction, bool stable) const {
    const auto& row = runs[prediction];
    return static_cast<double>(row[stable]) / (row[0] + row[1]);
  }
};

/// Runs scenes, and compares their verdicts with their lints.
class Trial {
 public:
  void Add(const std::string& theme, const plan::Scene& scene) {
    const Recorded recorded = RunHere(scene);
    if (!recorded.done()) {
      ++failed_;  // beyond the precision: rejected when it is placed or built
      return;
    }
    const protocol::Judgement judged =
        protocol::Judge(scene, recorded.recording, recorded.header().cycles_done.load());
    ASSERT_NE(judged.verdict, protocol::Verdict::kUnknown);
    const bool stable = judged.verdict == protocol::Verdict::kStable;
    const auto numbers = lints::LintScene(scene);
    const Prediction prediction = PredictionOf(numbers);
    ++all_.runs[prediction][stable];
    ++themes_[theme].runs[prediction][stable];
    if (prediction == kDoubtful || stable == (prediction == kSound)) return;
    surprises_ += fmt::format("  {}: {}:", theme, VerdictName(judged.verdict));
    for (const lints::LintNumber& number : numbers)
      if (number.Severity() > 0.1)
        surprises_ += fmt::format(" {} {:.2g}", InfoOf(number.lint).kind.id, number.Severity());
    surprises_ += "\n";
  }

  void PrintAndCheck(int most_failed) const {
    std::string table =
        fmt::format("{:28} {:>20} {:>20} {:>20}\n", world::EnginePrecision(), "sound: stable, not",
                    "doubtful: stable, not", "bad: stable, not");
    const auto add = [&table](std::string_view name, const Confusion& confusion) {
      table += fmt::format("{:28}", name);
      for (const auto& row : confusion.runs) table += fmt::format(" {:14} {:5}", row[1], row[0]);
      table += "\n";
    };
    for (const auto& [name, confusion] : themes_) add(name, confusion);
    add("all", all_);
    std::printf("%s%d failed to begin\nsurprises, with numbers over their limits:\n%s",
                table.c_str(), failed_, surprises_.c_str());
    EXPECT_LE(failed_, most_failed);
    EXPECT_GE(all_.Agreement(kSound, true), kAgreement);
    EXPECT_GE(all_.Agreement(kBad, false), kAgreement);
  }

 private:
  Confusion all_;
  std::map<std::string, Confusion> themes_;
  int failed_ = 0;
  std::string surprises_;
};

TEST(Lints, PredictTheVerdictsOfTheStabilitySuite) {
  const std::string library = SourceFolder() / "library/scenarios";
  Trial trial;
  for (const auto& entry : std::filesystem::directory_iterator(library + "/stability")) {
    const auto compiled = compiler::Compile(entry.path(), compiler::ReadFromDisk, {library, {}});
    for (const plan::Plan& plan : compiled.plans) {
      for (const plan::Run& run : plan.runs | std::views::take(kMostSuiteRuns)) {
        plan::Scene scene = run.scene;
        SetWorld(scene, "precision", Word(world::EnginePrecision()));
        trial.Add(plan.benchmark, scene);
      }
    }
  }
  trial.PrintAndCheck(0);
}

TEST(Lints, PredictTheVerdictsOfRandomScenes) {
  Trial trial;
  for (const RandomScene& random : RandomScenes(kScenes, kSeed))
    trial.Add(std::string(random.theme), random.scene);
  trial.PrintAndCheck(kScenes / 20);
}

}  // namespace
}  // namespace cdb::tests
