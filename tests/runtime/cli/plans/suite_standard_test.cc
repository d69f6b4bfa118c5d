// The scenes of the standard suite, and the page of their figures.
#include "runtime/figures/suite.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/support/files.h"
#include "tests/support/folders.h"

namespace cdb::tests {
namespace {

TEST(Standard, ThePageOfFiguresIsOfTheScenesThatThereAre) {
  const std::string page = ReadFile(SourceFolder() / "library/scenarios/standard/which_one.md");
  const auto expect = [&](const std::string& part) {
    EXPECT_NE(page.find(part), std::string::npos)
        << part << "\nis not in which_one.md: run `cdb suite` and write its figures there";
  };
  expect(fmt::format("Standard suite {}, short", figures::kSuiteVersion));
  for (const figures::SuiteKind& kind : figures::SuiteKinds())
    expect(fmt::format("\n{}: {}\n", kind.name, kind.doc));
  for (const figures::StandardScene& scene : figures::StandardScenes()) {
    expect(fmt::format("\n  {} ", scene.Id()));
    if (scene.kind != "stiff") expect(fmt::format("(`{}`)", scene.Id()));
  }
}

}  // namespace
}  // namespace cdb::tests
