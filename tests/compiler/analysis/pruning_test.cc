// Components of the engine that a run can omit, as far as its parameters determine it.
#include "compiler/analysis/pruning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "compiler/schema/schema.h"
#include "dsl/diagnostics.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

/// The scene of a benchmark with these statements.
plan::Scene SceneOf(const std::string& statements) {
  const compiler::Compilation result = CompileText("benchmark b {\n" + statements + "\n}\n");
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  return result.plans.empty() ? plan::Scene() : result.plans[0].runs.at(0).scene;
}

const analysis::PruningDecision& DecisionOf(const std::vector<analysis::PruningDecision>& decisions,
                                            schema::Component component) {
  return decisions.at(static_cast<std::size_t>(component));
}

TEST(Components, AreOneRowEachInTheOrderOfTheEnum) {
  std::set<std::string_view> names;
  int index = 0;
  for (const schema::ComponentInfo& info : schema::Components()) {
    EXPECT_EQ(static_cast<int>(info.component), index++) << info.name;
    EXPECT_EQ(&schema::InfoOf(info.component), &info);
    EXPECT_EQ(schema::FindComponent(info.name), &info);
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    EXPECT_FALSE(info.doc.empty()) << info.name;
    EXPECT_EQ(info.IsVisible(), !info.changes.empty()) << info.name;
    // A word of the language: letters, digits and _, beginning with a letter.
    EXPECT_EQ(info.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz_"), std::string_view::npos);
    EXPECT_TRUE(info.name != "auto" && info.name != "none");
  }
  EXPECT_EQ(index, static_cast<int>(schema::Component::kWallPairs) + 1);
  EXPECT_EQ(schema::FindComponent("gyro"), nullptr);
  EXPECT_EQ(schema::FindComponent(""), nullptr);
}

struct Row {
  schema::Component component;
  const char* statements;
  analysis::Decision decision;
  const char* why;  ///< a part of the reason
};

const Row kRows[] = {
    {schema::Component::kWalls, "", analysis::Decision::kOpen, "all objects are placed"},
    {schema::Component::kWalls, "world.walls floor", analysis::Decision::kOpen,
     "all objects are placed"},
    {schema::Component::kWalls, "world.walls none", analysis::Decision::kAbsent, "none stand"},
    {schema::Component::kWalls, "world.walls none; objects.ccd on", analysis::Decision::kAbsent,
     "none stand"},
    {schema::Component::kWalls, "objects.ccd on", analysis::Decision::kKept, "objects have ccd"},
    {schema::Component::kWalls, "objects stones { ccd any(on, off) }", analysis::Decision::kKept,
     "stones have ccd"},
    {schema::Component::kWalls, "objects a { quantity 3 }\nobjects b { quantity 0; ccd on }",
     analysis::Decision::kOpen, "all objects are placed"},

    {schema::Component::kWalls, "objects.links.type ball", analysis::Decision::kKept,
     "objects are linked"},
    {schema::Component::kWalls, "objects a { quantity 0; links.type ball } objects b { }",
     analysis::Decision::kOpen, "all objects are placed"},

    {schema::Component::kRaycastTree, "detector sap", analysis::Decision::kLeftOut,
     "no object has ccd"},
    {schema::Component::kRaycastTree, "detector sap32", analysis::Decision::kLeftOut,
     "no object has ccd"},
    {schema::Component::kRaycastTree, "detector sap32; objects.ccd on", analysis::Decision::kKept,
     "objects have ccd"},
    {schema::Component::kRaycastTree, "detector dbvt", analysis::Decision::kAbsent,
     "dbvt has none"},
    {schema::Component::kRaycastTree, "detector simple; objects.ccd on",
     analysis::Decision::kAbsent, "simple has none"},

    {schema::Component::kWalls, "queries { }", analysis::Decision::kKept, "queries may find them"},
    {schema::Component::kWalls, "queries { count 0 }", analysis::Decision::kOpen,
     "all objects are placed"},
    {schema::Component::kRaycastTree, "detector sap; queries { }", analysis::Decision::kKept,
     "the queries use it"},
    {schema::Component::kRaycastTree,
     "detector sap32; queries a { implementation tree } queries b { }", analysis::Decision::kKept,
     "the queries b use it"},
    {schema::Component::kRaycastTree, "detector sap; queries { implementation tree }",
     analysis::Decision::kLeftOut, "no object has ccd"},
    {schema::Component::kDetection, "record poses; queries { }", analysis::Decision::kKept,
     "Bullet answers the queries"},
    {schema::Component::kDetection, "record poses; queries { implementation tree }",
     analysis::Decision::kOpen, "can touch"},

    {schema::Component::kDetection, "", analysis::Decision::kKept, "record timing asks"},
    {schema::Component::kDetection, "record counts", analysis::Decision::kKept,
     "record counts asks"},
    {schema::Component::kDetection, "record contacts, poses", analysis::Decision::kKept,
     "record contacts asks"},
    {schema::Component::kDetection, "record poses, energy, stability, memory",
     analysis::Decision::kOpen, "can touch"},
    {schema::Component::kDetection, "record poses; objects.ccd on", analysis::Decision::kKept,
     "objects have ccd"},
    {schema::Component::kDetection, "omit detection", analysis::Decision::kOpen, "can touch"},

    {schema::Component::kSolver, "", analysis::Decision::kOpen, "can touch"},
    {schema::Component::kSolver, "objects.ccd on", analysis::Decision::kKept, "objects have ccd"},
    {schema::Component::kSolver, "objects chain { links { type spring } }",
     analysis::Decision::kKept, "chain are linked"},

    {schema::Component::kSleeping, "sleeping on", analysis::Decision::kOpen, "come to rest"},
    {schema::Component::kSleeping, "sleeping off", analysis::Decision::kAbsent, "sleeping is off"},

    {schema::Component::kSweptContacts, "", analysis::Decision::kLeftOut, "no object has ccd"},
    {schema::Component::kSweptContacts, "objects.ccd on", analysis::Decision::kKept,
     "objects have ccd"},

    {schema::Component::kGravity, "", analysis::Decision::kKept, "(0, -9.8, 0)"},
    {schema::Component::kGravity, "acceleration 0", analysis::Decision::kLeftOut,
     "the acceleration is 0"},
    {schema::Component::kGravity, "acceleration (0, 0, 1e-300)", analysis::Decision::kKept,
     "(0, 0, 1e-300)"},
    {schema::Component::kGravity, "acceleration normal(0, 1)", analysis::Decision::kKept,
     "normal(0, 1)"},
    {schema::Component::kGravity, "acceleration rotating((0, -9.8, 0), (0, 0, 1), 4)",
     analysis::Decision::kKept, "the acceleration is rotating((0, -9.8, 0), (0, 0, 1), 4)"},
    {schema::Component::kGravity, "acceleration every(60, 0)", analysis::Decision::kKept,
     "every(60, (0, 0, 0))"},

    {schema::Component::kDamping, "", analysis::Decision::kLeftOut, "no object is damped"},
    {schema::Component::kDamping, "objects.linear_damping 0.1", analysis::Decision::kKept,
     "objects have linear_damping"},
    {schema::Component::kDamping, "objects a { } objects b { angular_damping uniform(0, 1) }",
     analysis::Decision::kKept, "b have angular_damping"},
    {schema::Component::kDamping, "objects.quantity 0; objects.angular_damping 1",
     analysis::Decision::kLeftOut, "no object is damped"},

    {schema::Component::kRotation, "", analysis::Decision::kOpen, "make an object spin"},
    {schema::Component::kRotation, "objects.links.type ball", analysis::Decision::kKept,
     "objects are linked"},
    {schema::Component::kRotation, "objects.angular_velocity (0, 1, 0)", analysis::Decision::kKept,
     "objects have angular_velocity"},
    {schema::Component::kRotation, "objects.angular_velocity uniform(-1, 1)",
     analysis::Decision::kKept, "objects have angular_velocity"},
    {schema::Component::kRotation, "objects.angular_velocity every(60, 0)",
     analysis::Decision::kKept, "objects have angular_velocity"},

    {schema::Component::kMotionStates, "", analysis::Decision::kLeftOut, "is not drawn"},
    {schema::Component::kMotionStates, "objects.ccd on", analysis::Decision::kLeftOut,
     "is not drawn"},

    {schema::Component::kStaticBoxes, "detector sap; sleeping off", analysis::Decision::kLeftOut,
     "do not move"},
    {schema::Component::kStaticBoxes, "detector sap; sleeping on", analysis::Decision::kOpen,
     "falls asleep"},
    {schema::Component::kStaticBoxes, "detector dbvt; sleeping off", analysis::Decision::kKept,
     "dbvt finds other pairs"},

    {schema::Component::kPools, "", analysis::Decision::kOpen, "number of contacts"},

    {schema::Component::kWallPairs, "pair_order sorted", analysis::Decision::kKept,
     "if omit names it"},
    {schema::Component::kWallPairs, "omit auto, wall_pairs; pair_order sorted",
     analysis::Decision::kOpen, "number of pieces"},
    {schema::Component::kWallPairs, "omit wall_pairs; world.wall_shape box",
     analysis::Decision::kAbsent, "walls are boxes"},
    {schema::Component::kWallPairs, "omit wall_pairs; world.walls none",
     analysis::Decision::kAbsent, "none stand"},
};

TEST(AnalysePruning, DecidesByTheNumbers) {
  std::set<std::pair<schema::Component, analysis::Decision>> seen;
  for (const Row& row : kRows) {
    const auto decisions = analysis::AnalysePruning(SceneOf(row.statements));
    ASSERT_EQ(decisions.size(), schema::Components().size());
    const analysis::PruningDecision& part = DecisionOf(decisions, row.component);
    EXPECT_EQ(part.component, row.component);
    EXPECT_EQ(part.decision, row.decision)
        << schema::InfoOf(row.component).name << " in " << row.statements;
    EXPECT_NE(part.why.find(row.why), std::string::npos) << part.why << " in " << row.statements;
    seen.emplace(row.component, part.decision);
  }
  for (const schema::ComponentInfo& info : schema::Components())
    EXPECT_TRUE(
        std::ranges::any_of(seen, [&](const auto& pair) { return pair.first == info.component; }))
        << info.name << " is in no row";
}

TEST(AnalysePruning, NoneKeepsEverything) {
  for (const analysis::PruningDecision& part :
       analysis::AnalysePruning(SceneOf("omit none; world.walls none; sleeping off"))) {
    EXPECT_EQ(part.decision, analysis::Decision::kKept);
    EXPECT_EQ(part.why, "omit none");
  }
}

TEST(AnalysePruning, AListKeepsWhatItDoesNotName) {
  const auto decisions =
      analysis::AnalysePruning(SceneOf("detector sap; omit raycast_tree, walls"));
  for (const analysis::PruningDecision& part : decisions) {
    if (part.component == schema::Component::kWalls) {
      EXPECT_EQ(part.decision, analysis::Decision::kOpen);
    } else if (part.component == schema::Component::kRaycastTree) {
      EXPECT_EQ(part.decision, analysis::Decision::kLeftOut);
    } else {
      EXPECT_EQ(part.decision, analysis::Decision::kKept);
      EXPECT_EQ(part.why, "omit does not list it");
    }
  }
}

TEST(RequestFor, IsByAutoByNameOrNotAtAll) {
  for (const schema::ComponentInfo& info : schema::Components()) {
    EXPECT_EQ(analysis::RequestFor(SceneOf(""), info.component),
              info.is_in_auto ? analysis::PruningRequest::kAuto : analysis::PruningRequest::kNo);
    EXPECT_EQ(analysis::RequestFor(SceneOf("omit none"), info.component),
              analysis::PruningRequest::kNo);
    EXPECT_EQ(analysis::RequestFor(SceneOf("omit pools"), info.component),
              info.component == schema::Component::kPools ? analysis::PruningRequest::kByName
                                                          : analysis::PruningRequest::kNo);
  }
}

TEST(RequestFor, TakesNamesBesideAuto) {
  const plan::Scene scene = SceneOf("omit auto, wall_pairs; pair_order sorted");
  using schema::Component;
  EXPECT_EQ(analysis::RequestFor(scene, Component::kWallPairs), analysis::PruningRequest::kByName);
  EXPECT_EQ(analysis::RequestFor(scene, Component::kWalls), analysis::PruningRequest::kAuto);
  EXPECT_FALSE(schema::InfoOf(Component::kWallPairs).is_in_auto);
  EXPECT_TRUE(schema::InfoOf(Component::kWallPairs).IsVisible());
}

TEST(DecisionsText, NamesEveryDecision) {
  EXPECT_EQ(analysis::DecisionsText({}), "");
  const analysis::PruningDecision decisions[] = {
      {schema::Component::kWalls, analysis::Decision::kOpen, "later"},
      {schema::Component::kRaycastTree, analysis::Decision::kAbsent, "dbvt has none"},
      {schema::Component::kGravity, analysis::Decision::kKept, "the acceleration is 1"},
      {schema::Component::kPools, analysis::Decision::kLeftOut, "room for 3: plenty"}};
  EXPECT_EQ(analysis::DecisionsText(decisions),
            "walls: open: later\nraycast_tree: none: dbvt has none\n"
            "gravity: kept: the acceleration is 1\npools: left out: room for 3: plenty\n");
}

TEST(OmittedNames, AreThoseLeftOut) {
  EXPECT_EQ(analysis::OmittedNames({}), "");
  EXPECT_EQ(analysis::OmittedNames(analysis::AnalysePruning(SceneOf("omit none"))), "");
  EXPECT_EQ(analysis::OmittedNames(
                analysis::AnalysePruning(SceneOf("detector sap; omit raycast_tree, gravity\n"
                                                 "acceleration 0"))),
            "raycast_tree gravity");
}

// Names are passed through shared memory of a fixed size (runtime/protocol/recording.h).
TEST(OmittedNames, OfAllComponentsFitTheRecording) {
  std::vector<analysis::PruningDecision> decisions;
  for (const schema::ComponentInfo& info : schema::Components())
    decisions.push_back({info.component, analysis::Decision::kLeftOut, ""});
  EXPECT_LT(analysis::OmittedNames(decisions).size(), 256u);
}

}  // namespace
}  // namespace cdb::tests
