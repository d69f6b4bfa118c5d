// Lints predict the verdicts of runs.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <ranges>
#include <string>

#include "compiler/compile.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/runtime/engine/foresight.h"
#include "tests/runtime/engine/random_scenes.h"
#include "tests/support/folders.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

// The ordinary build compares the verdicts; sanitizers check the same code in fewer scenes.
constexpr std::size_t kScenes = kAddressSanitizer ? 100 : 1700;
constexpr std::size_t kMostSuiteRuns = kAddressSanitizer ? 3 : 1000;
constexpr std::uint64_t kSeed = 1;
/// 92.8 % in single precision: contacts that give a little energy are not all foreseen, nor are
/// impacts off by an eighth, 14 of 849. Of the 18 scenes under the sanitizers, two differ.
constexpr double kAgreement = kAddressSanitizer ? 0.85 : 0.92;

/// Runs scenes, and compares their verdicts with their lints.
class Trial {
 public:
  void Add(const std::string& theme, const plan::Scene& scene) {
    const auto foresight = Foresee(scene);
    if (!foresight) {
      ++failed_;  // beyond the precision: rejected when it is placed or built
      return;
    }
    table_.Add(theme, *foresight);
    const Prediction prediction = foresight->prediction();
    if (prediction == kDoubtful || foresight->is_stable() == (prediction == kSound)) return;
    surprises_ += fmt::format("  {}: {}\n", theme, foresight->Text());
  }

  void PrintAndCheck(int most_failed) const {
    std::printf("%s%d failed to begin\nsurprises, with numbers over their limits:\n%s",
                table_.Text().c_str(), failed_, surprises_.c_str());
    EXPECT_LE(failed_, most_failed);
    EXPECT_GE(table_.all().Agreement(kSound, true), kAgreement);
    EXPECT_GE(table_.all().Agreement(kBad, false), kAgreement);
  }

 private:
  ConfusionTable table_;
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
