// Properties of the errors in any text, tested with mutants of the golden files.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "dsl/diagnostics.h"
#include "tests/dsl/random_text.h"
#include "tests/support/compile_text.h"
#include "tests/support/files.h"
#include "tests/support/folders.h"

namespace cdb::tests {
namespace {

constexpr int kMutants = 8;  // of each file

std::vector<std::string> GoldenTexts() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(SourceFolder() / "tests" / "golden"))
    if (entry.path().extension() == ".cdb") files.push_back(entry.path());
  std::ranges::sort(files);
  std::vector<std::string> texts;
  for (const auto& file : files) texts.push_back(ReadFile(file));
  return texts;
}

/// An error that shares a character or its position with another; nullptr if there is none.
const dsl::Diagnostic* FirstOverlap(const dsl::Diagnostics& diagnostics) {
  const auto end_of = [](const dsl::Diagnostic& one) {
    return std::max(one.span.end, one.span.begin + 1);
  };
  std::vector<const dsl::Diagnostic*> errors;
  for (const dsl::Diagnostic& one : diagnostics.all())
    if (one.kind->severity() == dsl::Severity::kError && one.span.source != nullptr)
      errors.push_back(&one);
  for (std::size_t i = 0; i < errors.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (errors[i]->span.source == errors[j]->span.source &&
          errors[i]->span.begin < end_of(*errors[j]) && errors[j]->span.begin < end_of(*errors[i]))
        return errors[i];
  return nullptr;
}

TEST(DiagnosticsProperty, TwoErrorsNeverOverlap) {
  RandomText random(7);
  std::size_t errors = 0;
  for (const std::string& text : GoldenTexts()) {
    for (int i = 0; i < kMutants; ++i) {
      const std::string mutant = i == 0 ? text : random.Mutate(text);
      if (mutant.size() > 4000) continue;  // all pairs are compared
      const compiler::Compilation result = CompileText(mutant, {{"rock.obj", "v 0 0 0"}});
      errors += static_cast<std::size_t>(result.diagnostics.error_count());
      const dsl::Diagnostic* overlap = FirstOverlap(result.diagnostics);
      EXPECT_EQ(overlap, nullptr) << overlap->message << "\n"
                                  << mutant << dsl::Render(result.diagnostics);
    }
  }
  EXPECT_GT(errors, 1000u);
}

TEST(DiagnosticsProperty, ElevenFaultsAreElevenErrors) {
  const std::string text =
      ReadFile(SourceFolder() / "tests" / "golden" / "compiler" / "errors" / "eleven.cdb");
  const compiler::Compilation result = CompileText(text);
  std::vector<std::string_view> codes;
  for (const dsl::Diagnostic& one : result.diagnostics.all()) codes.push_back(one.kind->code);
  EXPECT_EQ(codes.size(), 11u) << dsl::Render(result.diagnostics);
  std::ranges::sort(codes);
  EXPECT_EQ(std::ranges::unique(codes).begin(), codes.end()) << "two are of one kind";
}

}  // namespace
}  // namespace cdb::tests
