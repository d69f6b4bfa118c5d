// The scenes of the standard suite, and the page of their figures.
#include "runtime/figures/suite.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/support/files.h"
#include "tests/support/folders.h"

namespace cdb::tests {
namespace {

/// The figures are of this version of the suite, or of an earlier one if the page says so.
TEST(Standard, ThePageOfFiguresIsOfTheScenesThatThereAre) {
  const std::string page = ReadFile(SourceFolder() / "library/scenarios/standard/which_one.md");
  const auto has = [&](const std::string& part) { return page.find(part) != std::string::npos; };
  int version = figures::kSuiteVersion;
  while (version > 1 && !has(fmt::format("Standard suite {}, short", version))) --version;
  EXPECT_TRUE(has(fmt::format("Standard suite {}, short", version)))
      << "run `cdb suite` and write its figures into which_one.md";
  if (version != figures::kSuiteVersion) {
    EXPECT_TRUE(has(fmt::format("They are of version {} of the suite.", version)));
    for (int later = version + 1; later <= figures::kSuiteVersion; ++later)
      EXPECT_TRUE(has(fmt::format("ersion {} ", later))) << "what it changed is not on the page";
  }
  for (const figures::StandardScene& scene : figures::StandardScenes())
    EXPECT_TRUE(has(scene.Id())) << scene.Id() << " is not in which_one.md";
}

}  // namespace
}  // namespace cdb::tests
