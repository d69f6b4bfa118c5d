#include "compiler/analysis/population.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "compiler/analysis/coverage.h"
#include "compiler/analysis/expectation.h"
#include "compiler/analysis/pruning.h"
#include "compiler/analysis/recorded.h"
#include "compiler/schema/catalogue.h"
#include "dsl/diagnostics.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

using testing::HasSubstr;

compiler::Compilation CompiledPopulation(const std::string& statements) {
  return CompileText("benchmark b { " + statements + " }");
}

plan::Scene PopulationScene(const std::string& statements) {
  const compiler::Compilation result = CompiledPopulation(statements);
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  return result.plans.at(0).runs.at(0).scene;
}

constexpr const char* kGrains = "objects grains { spawn { batch 5; every 4; start 2 } } ";

TEST(Population, ObjectsAreDueInTurn) {
  const analysis::Spawning spawning{5, 4, 2};
  const std::uint64_t due[] = {0, 0, 5, 5, 5, 5, 10, 10, 10, 10, 12, 12};
  for (std::uint64_t cycle = 0; cycle < std::size(due); ++cycle)
    EXPECT_EQ(spawning.DueAt(cycle, 12), due[cycle]) << cycle;
  // No number overflows.
  const analysis::Spawning many{2147483647, 1, 0};
  EXPECT_EQ(many.DueAt(std::uint64_t{1} << 62, 2147483647), 2147483647u);
}

TEST(Population, IsReadFromTheSettings) {
  const plan::Scene scene = PopulationScene(
      "objects a { spawn { batch 3 } } objects b { remove { below -5 m; after 7 } } objects c { "
      "remove.outside cube } objects d { remove { outside box((-1, -2, -3), (1, 2, 3)) } } objects "
      "e { }");
  EXPECT_EQ(analysis::SpawningOf(scene.groups[0])->count, 3u);
  EXPECT_EQ(analysis::SpawningOf(scene.groups[0])->every, 1u);
  EXPECT_EQ(analysis::SpawningOf(scene.groups[0])->start, 0u);
  EXPECT_FALSE(analysis::RemovalOf(scene.groups[0]));
  EXPECT_FALSE(analysis::SpawningOf(scene.groups[1]));
  EXPECT_EQ(*analysis::RemovalOf(scene.groups[1])->below, -5);
  EXPECT_EQ(*analysis::RemovalOf(scene.groups[1])->after, 7u);
  EXPECT_TRUE(analysis::RemovalOf(scene.groups[2])->outside_cube);
  EXPECT_NE(analysis::RemovalOf(scene.groups[3])->outside_box, nullptr);
  EXPECT_FALSE(analysis::SpawningOf(scene.groups[4]) || analysis::RemovalOf(scene.groups[4]));
  EXPECT_EQ(analysis::FindChanging(scene), &scene.groups[0]);
  // Without objects, none come.
  EXPECT_FALSE(analysis::ComesOrGoes(PopulationScene("objects { quantity 0; spawn { batch 3 } }")));
}

TEST(Population, RefusesByNameWhatAssumesAFixedSet) {
  struct Case {
    const char *statements, *message;
  };
  constexpr Case kCases[] = {
      {"detector fcl_ssap", "'fcl_ssap' is told of its bodies once"},
      {"narrow_phase ccd_gjk", "'ccd_gjk' is told of its bodies once"},
      {"record boxes", "'boxes' cannot be recorded"},
      {"accuracy { metrics energy }", "errors compare the same objects"},
      {"expect rest", "cannot stay at rest"},
      {"expect energy", "cannot keep its energy"},
      {"queries { count 5 }", "queries ask the same bodies"},
      {"objects grains { mass fixed }", "must be free to move"},
      {"objects grains { mass kinematic; linear_velocity (1, 0, 0) }", "must be free to move"},
      {"objects grains { links { type ball } }", "'links.type' cannot act"},
      {"objects grains { force (1, 0, 0) }", "'force' cannot act"},
      {"objects grains { torque (1, 0, 0) }", "'torque' cannot act"},
      {"objects grains { linear_velocity every(5, (0, 1, 0)) }", "schedules do not reach"},
      {"objects grains { location normal }", "come at places that are drawn uniformly"},
      {"objects grains { location grid }", "come at places that are drawn uniformly"},
      {"objects heap { location pile }", "a pile settles before the first cycle"},
      {"objects other { region above(grains) }", "there are no objects of grains at the start"},
      {"objects other { quantity 1 } objects grains { region above(other) }",
       "spawn in a box that is known at the start"},
      {"objects other { spawn { every 5 } }", "all objects of other are there from the start"},
      {"objects base { quantity 1 } objects other { quantity 1; remove { after 5 } } joints { "
       "parent base; child other }",
       "no joint holds them"},
  };
  const compiler::Compilation base = CompiledPopulation(kGrains);
  ASSERT_FALSE(base.diagnostics.has_errors()) << dsl::Render(base.diagnostics);
  for (const Case& one : kCases) {
    const compiler::Compilation result = CompiledPopulation(std::string(kGrains) + one.statements);
    EXPECT_TRUE(result.diagnostics.has_errors()) << one.statements;
    EXPECT_THAT(dsl::Render(result.diagnostics), HasSubstr(one.message)) << one.statements;
  }
}

TEST(Population, RefusesSoftBodiesThatComeAndGo) {
  for (const char* changes : {"spawn { batch 1 }", "remove { below -5 }", "remove.outside cube"})
    EXPECT_THAT(dsl::Render(CompiledPopulation(std::string("world { walls none } objects { "
                                                           "quantity 5; size 1; type "
                                                           "rope(segments: 3); ") +
                                               changes + " }")
                                .diagnostics),
                HasSubstr("beside soft bodies, no objects come or go"));
}

TEST(Population, EveryDetectorOfCdbAndBulletKnowsChanges) {
  for (const schema::DetectorInfo& info : schema::Detectors()) {
    const std::string phase = info.HasPhase("broad") ? "detector " : "narrow_phase ";
    const compiler::Compilation result =
        CompiledPopulation(kGrains + phase + std::string(info.name));
    EXPECT_EQ(result.diagnostics.has_errors(), !info.part.empty())
        << info.name << dsl::Render(result.diagnostics);
  }
}

TEST(Population, OnlySeriesWithoutAPastAreRecorded) {
  const plan::Scene changing = PopulationScene(kGrains);
  EXPECT_EQ(analysis::KindOf(changing), analysis::RunKind::kChanging);
  const plan::Scene fixed = PopulationScene("objects { }");
  for (const char* name : {"present", "spawned", "departed", "waiting", "change_time"}) {
    EXPECT_TRUE(analysis::IsRecordedBy(*schema::FindSeries(name), changing)) << name;
    EXPECT_FALSE(analysis::IsRecordedBy(*schema::FindSeries(name), fixed)) << name;
  }
  for (const char* name : {"duration", "pairs", "contacts", "max_penetration", "escaped", "energy"})
    EXPECT_TRUE(analysis::IsRecordedBy(*schema::FindSeries(name), changing)) << name;
  for (const char* name : {"displacement", "motion_ratio", "passed", "unheld", "gained_energy"})
    EXPECT_FALSE(analysis::IsRecordedBy(*schema::FindSeries(name), changing)) << name;
}

TEST(Population, NothingIsProvenFromTheStart) {
  const plan::Scene scene = PopulationScene(kGrains);
  EXPECT_EQ(analysis::ExpectationOf(scene), analysis::Expectation::kDriven);
  EXPECT_EQ(analysis::CheckedText(analysis::CoverageOf(scene)), "");
  for (const analysis::Coverage::Open& open : analysis::CoverageOf(scene).unchecked)
    EXPECT_THAT(open.why, HasSubstr("come and go")) << open.question->name;
  for (const analysis::PruningDecision& part : analysis::AnalysePruning(scene))
    if (part.component == schema::Component::kWalls ||
        part.component == schema::Component::kStaticBoxes ||
        part.component == schema::Component::kSleeping) {
      EXPECT_EQ(part.decision, analysis::Decision::kKept) << part.why;
    }
}

TEST(Repose, NeedsAFloorAndConstantGravityTowardsIt) {
  const auto errors = [](const std::string& statements) {
    return dsl::Render(
        CompileText("benchmark b { record repose; objects { size 1 } " + statements + " }")
            .diagnostics);
  };
  const std::string floor = "world.walls floor; ";
  EXPECT_EQ(errors(floor), "");
  EXPECT_EQ(errors("world.walls all; acceleration (0, -1.62, 0)"), "");
  for (const std::string& statements :
       {std::string("world.walls none"), floor + "acceleration (0, 0, 0)",
        floor + "acceleration (0, 9.81, 0)", floor + "acceleration (0.1, -9.81, 0)",
        floor + "acceleration every(60, uniform((0, -9, 0), (0, -1, 0)))"})
    EXPECT_THAT(errors(statements), HasSubstr("no floor, or no constant gravity along -y"))
        << statements;
  // Without the word, all of them may be.
  EXPECT_EQ(
      dsl::Render(
          CompileText("benchmark b { world.walls none; acceleration (1, 2, 3) }").diagnostics),
      "");
}

}  // namespace
}  // namespace cdb::tests
