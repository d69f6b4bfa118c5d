// Each tests/golden/dsl/NAME.cdb renders to NAME.txt. With CDB_UPDATE_GOLDEN=1 in the environment,
// the expected files are rewritten instead.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "dsl/diagnostics.h"
#include "dsl/parser.h"
#include "tests/support/files.h"
#include "tests/support/folders.h"

namespace cdb::tests {
using namespace dsl;

namespace {

namespace fs = std::filesystem;

const fs::path kFolder = SourceFolder() / "tests" / "golden" / "dsl";

std::vector<fs::path> Inputs() {
  std::vector<fs::path> inputs;
  for (const auto& entry : fs::directory_iterator(kFolder))
    if (entry.path().extension() == ".cdb") inputs.push_back(entry.path());
  std::sort(inputs.begin(), inputs.end());
  return inputs;
}

dsl::Diagnostics DiagnosticsOf(const fs::path& input, std::string* rendered) {
  dsl::Diagnostics diagnostics;
  const auto source =
      std::make_shared<const text::Source>(input.filename().string(), ReadFile(input));
  dsl::Parse(source, diagnostics);
  *rendered = dsl::Render(diagnostics);
  return diagnostics;
}

TEST(Golden, RenderedDiagnostics) {
  const char* wanted = std::getenv("CDB_UPDATE_GOLDEN");
  const bool update = wanted != nullptr && std::string(wanted) == "1";
  ASSERT_FALSE(Inputs().empty());
  for (const fs::path& input : Inputs()) {
    std::string rendered;
    DiagnosticsOf(input, &rendered);
    fs::path expected = input;
    expected.replace_extension(".txt");
    if (update) WriteFile(expected, rendered);
    ASSERT_TRUE(fs::exists(expected)) << expected;
    EXPECT_EQ(rendered, ReadFile(expected)) << input.filename();
  }
}

// Every kind of diagnostic has a golden file with its name.
TEST(Golden, EveryKindIsShown) {
  std::set<std::string_view> ids;
  for (const dsl::DiagnosticKind* kind : kDiagnosticKinds) {
    EXPECT_TRUE(ids.insert(kind->id).second) << kind->id << " is listed twice";
    const fs::path input = kFolder / (std::string(kind->id) + ".cdb");
    ASSERT_TRUE(fs::exists(input)) << input;
    std::string rendered;
    const dsl::Diagnostics diagnostics = DiagnosticsOf(input, &rendered);
    EXPECT_TRUE(std::any_of(diagnostics.all().begin(), diagnostics.all().end(),
                            [&](const dsl::Diagnostic& d) { return d.kind == kind; }))
        << kind->id;
  }
}

TEST(Golden, NoExpectationIsLeftOver) {
  for (const auto& entry : fs::directory_iterator(kFolder)) {
    if (entry.path().extension() != ".txt") continue;
    fs::path input = entry.path();
    EXPECT_TRUE(fs::exists(input.replace_extension(".cdb"))) << entry.path();
  }
}

}  // namespace
}  // namespace cdb::tests
