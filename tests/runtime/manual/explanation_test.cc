#include "runtime/manual/explanation.h"

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <set>
#include <string>

#include "compiler/compile.h"
#include "compiler/lints/lints.h"
#include "compiler/scenario/diagnostic_kinds.h"
#include "dsl/diagnostics.h"
#include "library/closed_forms/scene_fault.h"
#include "runtime/protocol/verdict.h"

namespace cdb::tests {
namespace {

TEST(Explanation, HasRemediesForEveryVerdict) {
  for (const protocol::VerdictInfo& info : protocol::Verdicts())
    EXPECT_NE(manual::RemedyText(info.name), "") << info.name;
  EXPECT_EQ(manual::RemedyNames().size(), protocol::Verdicts().size() + 1);  // and noisy
  EXPECT_EQ(manual::RemedyText("E0201"), "");
}

std::vector<const dsl::DiagnosticKind*> AllKinds() {
  std::vector<const dsl::DiagnosticKind*> kinds(std::begin(dsl::kDiagnosticKinds),
                                                std::end(dsl::kDiagnosticKinds));
  kinds.insert(kinds.end(), std::begin(scenario::kDiagnosticKinds),
               std::end(scenario::kDiagnosticKinds));
  for (const lints::LintInfo& info : lints::Lints()) kinds.push_back(&info.kind);
  return kinds;
}

/// Compiles as `cdb check` does.
compiler::Compilation CompileExample(std::string_view text) {
  const auto read = [&](const std::string& path, std::string& why) -> std::optional<std::string> {
    if (path == "wrong.cdb") return std::string(text);
    if (auto file = manual::ExampleFile(path)) return file;
    why = "No such file or directory";
    return std::nullopt;
  };
  const auto describe = [](const std::string&, const std::string& path,
                           std::string& why) -> std::optional<std::vector<schema::PluginDetector>> {
    why = "'" + path + "' is no plug-in";
    return std::nullopt;
  };
  return compiler::Compile("wrong.cdb", read,
                           {"",
                            std::nullopt,
                            {{}, describe},
                            {},
                            closed_forms::FindSceneFault,
                            {},
                            manual::ExampleModel});
}

TEST(Explanation, EveryKindHasACodeOfItsOwn) {
  std::set<std::string_view> codes;
  for (const dsl::DiagnosticKind* kind : AllKinds()) {
    EXPECT_EQ(kind->code.size(), 5u) << kind->id;
    EXPECT_TRUE(kind->code[0] == 'E' || kind->code[0] == 'W') << kind->id;
    EXPECT_EQ(kind->code.find_first_not_of("0123456789", 1), std::string_view::npos) << kind->id;
    EXPECT_FALSE(kind->id.empty()) << kind->code;
    EXPECT_TRUE(codes.insert(kind->code).second) << kind->code << " is of two kinds";
  }
}

TEST(Explanation, EveryKindHasOne) {
  std::map<const dsl::DiagnosticKind*, int> count;
  for (const manual::Explanation* row : manual::AllExplanations()) ++count[row->kind];
  EXPECT_EQ(count.size(), AllKinds().size());
  for (const dsl::DiagnosticKind* kind : AllKinds())
    EXPECT_EQ(count[kind], 1) << kind->code << ' ' << kind->id;
}

TEST(Explanation, TheWrongExampleHasThisKindAndNoOther) {
  for (const manual::Explanation* row : manual::AllExplanations()) {
    const compiler::Compilation result = CompileExample(row->wrong);
    EXPECT_FALSE(result.diagnostics.all().empty()) << row->kind->id << "\n" << row->wrong;
    for (const dsl::Diagnostic& diagnostic : result.diagnostics.all())
      EXPECT_EQ(diagnostic.kind, row->kind) << row->kind->id << "\n"
                                            << row->wrong << dsl::Render(result.diagnostics);
  }
}

TEST(Explanation, TheRightExampleHasNoDiagnostics) {
  for (const manual::Explanation* row : manual::AllExplanations()) {
    const compiler::Compilation result = CompileExample(row->right);
    EXPECT_TRUE(result.diagnostics.all().empty()) << row->kind->id << "\n"
                                                  << row->right << dsl::Render(result.diagnostics);
    EXPECT_FALSE(result.plans.empty()) << row->kind->id;
  }
}

TEST(Explanation, IsFoundByCodeOrName) {
  ASSERT_EQ(manual::FindExplanations("e0201").size(), 1u);
  EXPECT_EQ(manual::FindExplanations("e0201")[0]->kind, &scenario::kUnknownName);
  EXPECT_EQ(manual::FindExplanations("tall-stack").size(), 1u);
  EXPECT_EQ(manual::FindExplanations("bad-range").size(), 2u);
  EXPECT_TRUE(manual::FindExplanations("E9999").empty());
}

}  // namespace
}  // namespace cdb::tests
