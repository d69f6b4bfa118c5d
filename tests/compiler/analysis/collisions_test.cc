#include "compiler/analysis/expectation.h"

#include <gtest/gtest.h>

#include "dsl/diagnostics.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

analysis::Collisions CollisionsOf(const std::string& groups) {
  const compiler::Compilation result = CompileText("benchmark b { " + groups + " }");
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  return analysis::Collisions(result.plans.at(0).runs.at(0).scene);
}

TEST(Collisions, AllTouchByDefault) {
  EXPECT_TRUE(CollisionsOf("objects a { size 1 } objects b { collides_with all }").AllMayTouch());
}

TEST(Collisions, NeedBothSides) {
  const analysis::Collisions got = CollisionsOf(
      "objects a { collides_with b, walls } objects b { size 1 } objects c { collides_with b, c }\n"
      "objects d { collides_with none }");
  EXPECT_FALSE(got.AllMayTouch());
  const char* expected[] = {"0100", "1110", "0110", "0000"};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      EXPECT_EQ(got.MayTouch(i, j), expected[i][j] == '1') << i << " " << j;
  const bool walls[] = {true, true, false, false};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(got.MayTouchWalls(i), walls[i]) << i;
  EXPECT_EQ(got.ClassCount(), 4u);
}

TEST(Collisions, GroupsThatTouchTheSameAreOneClass) {
  const analysis::Collisions got = CollisionsOf(
      "objects a { size 1 } objects b { size 1 } objects ghosts { collides_with walls }\n"
      "objects more_ghosts { collides_with walls }");
  EXPECT_EQ(got.ClassCount(), 2u);
  EXPECT_EQ(got.ClassOf(0), got.ClassOf(1));
  EXPECT_EQ(got.ClassOf(2), got.ClassOf(3));
}

TEST(Collisions, AreRefusedBeyondBulletsMasks) {
  std::string groups;
  for (char name = 'a'; name <= 'm'; ++name)
    groups += std::string("objects ") + name + " { collides_with " + name + " }\n";
  const compiler::Compilation result = CompileText("benchmark b { " + groups + " }");
  EXPECT_NE(dsl::Render(result.diagnostics).find("makes 13 kinds of groups"), std::string::npos)
      << dsl::Render(result.diagnostics);
}

}  // namespace
}  // namespace cdb::tests
