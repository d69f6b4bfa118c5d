// Scenes whose fate was written down before they were run (fates/*.cdb): the verdict must find it
// afterwards, and the lints must foresee it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "compiler/compile.h"
#include "dsl/diagnostics.h"
#include "library/closed_forms/scene_fault.h"
#include "library/layouts/pose_table.h"
#include "tests/runtime/engine/engine_fixture.h"
#include "tests/runtime/engine/foresight.h"
#include "tests/support/folders.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

// The ordinary build runs every scene; sanitizers check the same code in the first of each sweep.
constexpr std::size_t kMostRuns = kAddressSanitizer ? 1 : 1000;

/// A benchmark is called good_*, bad_*, or bad32_* if only single precision spoils it.
bool IsGood(const std::string& benchmark) {
  if (benchmark.starts_with("bad32_")) return !kIsSingle;
  EXPECT_TRUE(benchmark.starts_with("good_") || benchmark.starts_with("bad_")) << benchmark;
  return benchmark.starts_with("good_");
}

/// Runs by what went wrong with their verdict or their lints.
class Fates {
 public:
  void RunAll(const std::filesystem::path& folder) {
    std::vector<std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.path().extension() == ".cdb") files.push_back(entry.path());
    std::ranges::sort(files);
    for (const std::string& file : files) {
      compiler::CompileOptions options;
      options.find_fault = closed_forms::FindSceneFault;
      options.read_poses = layouts::ReadPoseFacts;
      const auto compiled = compiler::Compile(file, compiler::ReadFromDisk, options);
      ASSERT_FALSE(compiled.diagnostics.has_errors()) << dsl::Render(compiled.diagnostics);
      for (const plan::Plan& plan : compiled.plans)
        for (std::size_t i = 0; i < std::min(kMostRuns, plan.runs.size()); ++i)
          Run(plan, plan.runs[i]);
    }
  }

  std::size_t Count(bool is_good) const { return counts_[is_good ? 1 : 0]; }
  const std::vector<std::string>& Of(const std::string& list) { return lists_[list]; }
  std::string Text() {
    std::string text = table_.Text();
    for (const auto& [name, runs] : lists_) {
      text += fmt::format("{}: {}\n", name, runs.size());
      for (const std::string& run : runs) text += "  " + run + "\n";
    }
    return text;
  }

 private:
  void Run(const plan::Plan& plan, const plan::Run& run) {
    plan::Scene scene = run.scene;
    SetWorld(scene, "precision", Word(world::EnginePrecision()));
    const std::string name = fmt::format("{} {}", plan.benchmark, Describe(plan, run));
    std::string why;
    const auto foresight = Foresee(scene, &why);
    ASSERT_TRUE(foresight) << name << ": " << why;
    const bool is_good = IsGood(plan.benchmark);
    ++counts_[is_good ? 1 : 0];
    table_.Add(plan.benchmark, *foresight);
    const auto list = [&](const std::string& which) {
      lists_[which].push_back(fmt::format("{}: {}", name, foresight->Text()));
    };
    if (!is_good && foresight->is_stable()) list("false stable");
    if (is_good && !foresight->is_stable()) list("false bad");
    if (is_good && foresight->prediction() == kBad) list("false will");
    if (is_good && foresight->prediction() == kDoubtful) list("good, but may");
    if (!is_good && foresight->prediction() == kSound) list("silent");
  }

  std::size_t counts_[2] = {};
  ConfusionTable table_;
  std::map<std::string, std::vector<std::string>> lists_;
};

TEST(Fates, AreJudgedAndForeseen) {
  Fates fates;
  fates.RunAll(SourceFolder() / "tests/runtime/engine/fates");
  std::printf("%s", fates.Text().c_str());
  EXPECT_EQ(fates.Of("false stable").size(), 0u);
  EXPECT_EQ(fates.Of("false bad").size(), 0u);
  EXPECT_EQ(fates.Of("false will").size(), 0u);
  // A share of all scenes: the first of each sweep are not spread as they are.
  if (!kAddressSanitizer) {
    EXPECT_LE(fates.Of("silent").size(), fates.Count(false) / 20);
  }
}

}  // namespace
}  // namespace cdb::tests
