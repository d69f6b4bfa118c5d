// The scenes of the standard suite, and the page of their figures.
#include "runtime/figures/suite.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/support/files.h"
#include "tests/support/folders.h"

namespace cdb::tests {
namespace {

/// The figures are of this version of the suite, or of the last one if the page says so.
TEST(Standard, ThePageOfFiguresIsOfTheScenesThatThereAre) {
  const std::string page = ReadFile(SourceFolder() / "library/scenarios/standard/which_one.md");
  const auto has = [&](const std::string& part) { return page.find(part) != std::string::npos; };
  const int version = figures::kSuiteVersion;
  const std::string older =
      fmt::format("They are of version {} of the suite. Version {} adds", version - 1, version);
  const std::string output =
      fmt::format("Standard suite {}, short", has(older) ? version - 1 : version);
  EXPECT_TRUE(has(output))
      << output << "\nis not in which_one.md: run `cdb suite` and write its figures there";
  for (const figures::StandardScene& scene : figures::StandardScenes())
    EXPECT_TRUE(has(scene.Id())) << scene.Id() << " is not in which_one.md";
}

}  // namespace
}  // namespace cdb::tests
