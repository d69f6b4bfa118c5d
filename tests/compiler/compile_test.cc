// Each tests/golden/compiler/errors/NAME.cdb renders to NAME.txt, and each benchmark of
// plans/NAME.cdb expands to NAME.BENCHMARK.txt, its plan without repetitions. With
// CDB_UPDATE_GOLDEN=1 in the environment, the expected files are rewritten instead.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "compiler/compile.h"
#include "compiler/lints/lints.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "compiler/yaml/plan_yaml.h"
#include "dsl/diagnostics.h"
#include "library/closed_forms/scene_fault.h"
#include "tests/support/compile_text.h"
#include "tests/support/files.h"
#include "tests/support/folders.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;

const fs::path kFolder = SourceFolder() / "tests" / "golden" / "compiler";

std::vector<fs::path> Inputs(const char* folder) {
  std::vector<fs::path> inputs;
  for (const auto& entry : fs::directory_iterator(kFolder / folder))
    if (entry.path().extension() == ".cdb") inputs.push_back(entry.path());
  std::ranges::sort(inputs);
  EXPECT_FALSE(inputs.empty());
  return inputs;
}

/// Compiles with names relative to the folder, so that golden files contain no absolute paths.
compiler::Compilation CompileHere(const fs::path& input) {
  const auto read = [&](const std::string& path, std::string& why) {
    return compiler::ReadFromDisk((input.parent_path() / path).string(), why);
  };
  return compiler::Compile(input.filename().string(), read,
                           {"",
                            std::nullopt,
                            {{}, DescribeText()},
                            MadeUpTraces,
                            closed_forms::FindSceneFault,
                            ReadTables(read),
                            MadeUpModels});
}

void ExpectGolden(const fs::path& file, const std::string& text) {
  const char* update = std::getenv("CDB_UPDATE_GOLDEN");
  if (update != nullptr && std::string(update) == "1") WriteFile(file, text);
  EXPECT_EQ(text, ReadFile(file)) << file;
}

/// A plan as YAML in which a run has only the lines that the previous run has not, and after `-`
/// those that it lacks.
std::string WithoutRepetitions(const std::string& yaml) {
  std::string condensed, line;
  std::vector<std::string> before, run;
  const auto add_others = [&](const auto& lines, const auto& known, const char* mark) {
    for (const std::string& one : lines)
      if (std::ranges::find(known, one) == known.end()) condensed += mark + one + "\n";
  };
  const auto end_run = [&] {
    if (run.empty()) return;
    add_others(before, run, "-");
    add_others(run, before, "");
    before = std::exchange(run, {});
  };
  std::istringstream lines(yaml);
  bool in_runs = false;
  while (std::getline(lines, line)) {
    if (!line.starts_with("    ")) end_run();
    if (!line.starts_with(" ")) in_runs = line == "runs:";
    if (in_runs && line.starts_with(" ")) {
      run.push_back(line);
    } else {
      condensed += line + "\n";
    }
  }
  end_run();
  return condensed;
}

TEST(Golden, ErrorsAndEveryKindOfThem) {
  std::set<std::string_view> seen;
  for (const fs::path& input : Inputs("errors")) {
    const compiler::Compilation result = CompileHere(input);
    EXPECT_TRUE(result.diagnostics.has_errors()) << input;
    EXPECT_TRUE(result.plans.empty()) << input;
    fs::path expected = input;
    ExpectGolden(expected.replace_extension(".txt"), dsl::Render(result.diagnostics));
    for (const auto& diagnostic : result.diagnostics.all()) seen.insert(diagnostic.kind->id);
  }
  for (const dsl::DiagnosticKind* kind : scenario::kDiagnosticKinds)
    EXPECT_TRUE(seen.contains(kind->id)) << kind->id << " is in no golden file";
}

TEST(Golden, LintsAndEveryOneOfThem) {
  std::set<std::string_view> seen;
  for (const fs::path& input : Inputs("lints")) {
    const compiler::Compilation result = CompileHere(input);
    EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
    EXPECT_EQ(result.plans.size(), result.benchmarks.size()) << input;
    fs::path expected = input;
    ExpectGolden(expected.replace_extension(".txt"), dsl::Render(result.diagnostics));
    for (const auto& diagnostic : result.diagnostics.all()) {
      EXPECT_TRUE(lints::IsLint(*diagnostic.kind)) << diagnostic.message;
      seen.insert(diagnostic.kind->id);
    }
  }
  for (const lints::LintInfo& info : lints::Lints())
    EXPECT_TRUE(seen.contains(info.kind.id)) << info.kind.id << " is in no golden file";
}

TEST(Golden, Plans) {
  for (const fs::path& input : Inputs("plans")) {
    const compiler::Compilation result = CompileHere(input);
    EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
    for (const plan::Plan& plan : result.plans) {
      const fs::path expected =
          input.parent_path() / (input.stem().string() + "." + plan.benchmark + ".txt");
      ExpectGolden(expected, WithoutRepetitions(yaml::ToYaml(plan)));
    }
  }
}

TEST(Compile, LongChainsOfLetsAreRefusedOnce) {
  std::string text;
  for (int i = 0; i < 2000; ++i) text += fmt::format("let a{} = a{} + 1\n", i, i + 1);
  const compiler::Compilation result = CompileText(text + "let a2000 = 1\nbenchmark b { }\n");
  EXPECT_EQ(result.diagnostics.error_count(), 1) << dsl::Render(result.diagnostics);
}

TEST(Compile, ALongLineOfBasesIsAllowed) {
  std::string text = "benchmark b0 { seed 5 }\n";
  for (int i = 0; i < 500; ++i) text += fmt::format("benchmark b{} from b{} {{ }}\n", i + 1, i);
  const compiler::Compilation result = CompileText(text);
  ASSERT_EQ(result.plans.size(), 501u) << dsl::Render(result.diagnostics);
  EXPECT_EQ(result.plans.back().runs.at(0).scene.world.Count("seed"), 5u);
}

}  // namespace
}  // namespace cdb::tests
