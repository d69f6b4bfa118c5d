// Components of the engine that a run can omit, as far as its parameters decide it.
#include "compiler/plan/pruning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "compiler/schema/schema.h"
#include "dsl/render.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

/// The scene of a benchmark with these statements.
plan::Scene SceneOf(const std::string& statements) {
  const compiler::Compilation result = CompileText("benchmark b {\n" + statements + "\n}\n");
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  return result.plans.empty() ? plan::Scene() : result.plans[0].runs.at(0).scene;
}

const plan::PruningDecision& DecisionOf(const std::vector<plan::PruningDecision>& decisions,
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
    // A word of the language: a letter, then letters, digits and _.
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
  plan::Decision decision;
  const char* why;  ///< a part of the reason
};

const Row kRows[] = {
    {schema::Component::kWalls, "", plan::Decision::kOpen, "all are placed"},
    {schema::Component::kWalls, "world.walls floor", plan::Decision::kOpen, "all are placed"},
    {schema::Component::kWalls, "world.walls none", plan::Decision::kAbsent, "none stand"},
    {schema::Component::kWalls, "world.walls none; objects.ccd on", plan::Decision::kAbsent,
     "none stand"},
    {schema::Component::kWalls, "objects.ccd on", plan::Decision::kKept, "objects have ccd"},
    {schema::Component::kWalls, "objects stones { ccd any(on, off) }", plan::Decision::kKept,
     "stones have ccd"},
    {schema::Component::kWalls, "objects a { quantity 3 }\nobjects b { quantity 0; ccd on }",
     plan::Decision::kOpen, "all are placed"},

    {schema::Component::kWalls, "objects.links.type ball", plan::Decision::kKept,
     "objects are linked"},
    {schema::Component::kWalls, "objects a { quantity 0; links.type ball } objects b { }",
     plan::Decision::kOpen, "all are placed"},

    {schema::Component::kRaycastTree, "detector sap", plan::Decision::kLeftOut,
     "no object has ccd"},
    {schema::Component::kRaycastTree, "detector sap32", plan::Decision::kLeftOut,
     "no object has ccd"},
    {schema::Component::kRaycastTree, "detector sap32; objects.ccd on", plan::Decision::kKept,
     "objects have ccd"},
    {schema::Component::kRaycastTree, "detector dbvt", plan::Decision::kAbsent, "dbvt has none"},
    {schema::Component::kRaycastTree, "detector simple; objects.ccd on", plan::Decision::kAbsent,
     "simple has none"},

    {schema::Component::kDetection, "", plan::Decision::kKept, "record timing asks"},
    {schema::Component::kDetection, "record counts", plan::Decision::kKept, "record counts asks"},
    {schema::Component::kDetection, "record contacts, poses", plan::Decision::kKept,
     "record contacts asks"},
    {schema::Component::kDetection, "record poses, energy, stability, memory",
     plan::Decision::kOpen, "can touch"},
    {schema::Component::kDetection, "record poses; objects.ccd on", plan::Decision::kKept,
     "objects have ccd"},
    {schema::Component::kDetection, "omit detection", plan::Decision::kOpen, "can touch"},

    {schema::Component::kSolver, "", plan::Decision::kOpen, "can touch"},
    {schema::Component::kSolver, "objects.ccd on", plan::Decision::kKept, "objects have ccd"},
    {schema::Component::kSolver, "objects chain { links { type spring } }", plan::Decision::kKept,
     "chain are linked"},

    {schema::Component::kSleeping, "sleeping on", plan::Decision::kOpen, "come to rest"},
    {schema::Component::kSleeping, "sleeping off", plan::Decision::kAbsent, "sleeping is off"},

    {schema::Component::kSweptContacts, "", plan::Decision::kLeftOut, "no object has ccd"},
    {schema::Component::kSweptContacts, "objects.ccd on", plan::Decision::kKept,
     "objects have ccd"},

    {schema::Component::kGravity, "", plan::Decision::kKept, "(0, -9.8, 0)"},
    {schema::Component::kGravity, "acceleration 0", plan::Decision::kLeftOut,
     "the acceleration is 0"},
    {schema::Component::kGravity, "acceleration (0, 0, 1e-300)", plan::Decision::kKept,
     "(0, 0, 1e-300)"},
    {schema::Component::kGravity, "acceleration normal(0, 1)", plan::Decision::kKept,
     "normal(0, 1)"},
    {schema::Component::kGravity, "acceleration rotating((0, -9.8, 0), (0, 0, 1), 4)",
     plan::Decision::kKept, "the acceleration is rotating((0, -9.8, 0), (0, 0, 1), 4)"},
    {schema::Component::kGravity, "acceleration every(60, 0)", plan::Decision::kKept,
     "every(60, (0, 0, 0))"},

    {schema::Component::kDamping, "", plan::Decision::kLeftOut, "no object is damped"},
    {schema::Component::kDamping, "objects.linear_damping 0.1", plan::Decision::kKept,
     "objects have linear_damping"},
    {schema::Component::kDamping, "objects a { } objects b { angular_damping uniform(0, 1) }",
     plan::Decision::kKept, "b have angular_damping"},
    {schema::Component::kDamping, "objects.quantity 0; objects.angular_damping 1",
     plan::Decision::kLeftOut, "no object is damped"},

    {schema::Component::kRotation, "", plan::Decision::kOpen, "set an object spinning"},
    {schema::Component::kRotation, "objects.links.type ball", plan::Decision::kKept,
     "objects are linked"},
    {schema::Component::kRotation, "objects.angular_velocity (0, 1, 0)", plan::Decision::kKept,
     "objects have angular_velocity"},
    {schema::Component::kRotation, "objects.angular_velocity uniform(-1, 1)", plan::Decision::kKept,
     "objects have angular_velocity"},
    {schema::Component::kRotation, "objects.angular_velocity every(60, 0)", plan::Decision::kKept,
     "objects have angular_velocity"},

    {schema::Component::kMotionStates, "", plan::Decision::kLeftOut, "draws the scene"},
    {schema::Component::kMotionStates, "objects.ccd on", plan::Decision::kLeftOut,
     "draws the scene"},

    {schema::Component::kStaticBoxes, "detector sap; sleeping off", plan::Decision::kLeftOut,
     "stay where they are"},
    {schema::Component::kStaticBoxes, "detector sap; sleeping on", plan::Decision::kOpen,
     "falls asleep"},
    {schema::Component::kStaticBoxes, "detector dbvt; sleeping off", plan::Decision::kKept,
     "dbvt finds other pairs"},

    {schema::Component::kPools, "", plan::Decision::kOpen, "how many contacts"},

    {schema::Component::kWallPairs, "pair_order sorted", plan::Decision::kKept, "if omit names it"},
    {schema::Component::kWallPairs, "omit auto, wall_pairs; pair_order sorted",
     plan::Decision::kOpen, "several pieces"},
    {schema::Component::kWallPairs, "omit wall_pairs; world.wall_shape box",
     plan::Decision::kAbsent, "walls are boxes"},
    {schema::Component::kWallPairs, "omit wall_pairs; world.walls none", plan::Decision::kAbsent,
     "none stand"},
};

TEST(AnalysePruning, DecidesByTheNumbers) {
  std::set<std::pair<schema::Component, plan::Decision>> seen;
  for (const Row& row : kRows) {
    const auto decisions = plan::AnalysePruning(SceneOf(row.statements));
    ASSERT_EQ(decisions.size(), schema::Components().size());
    const plan::PruningDecision& part = DecisionOf(decisions, row.component);
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
  for (const plan::PruningDecision& part :
       plan::AnalysePruning(SceneOf("omit none; world.walls none; sleeping off"))) {
    EXPECT_EQ(part.decision, plan::Decision::kKept);
    EXPECT_EQ(part.why, "omit none");
  }
}

TEST(AnalysePruning, AListKeepsWhatItDoesNotName) {
  const auto decisions = plan::AnalysePruning(SceneOf("detector sap; omit raycast_tree, walls"));
  for (const plan::PruningDecision& part : decisions) {
    if (part.component == schema::Component::kWalls) {
      EXPECT_EQ(part.decision, plan::Decision::kOpen);
    } else if (part.component == schema::Component::kRaycastTree) {
      EXPECT_EQ(part.decision, plan::Decision::kLeftOut);
    } else {
      EXPECT_EQ(part.decision, plan::Decision::kKept);
      EXPECT_EQ(part.why, "omit does not list it");
    }
  }
}

TEST(RequestFor, IsByAutoByNameOrNotAtAll) {
  for (const schema::ComponentInfo& info : schema::Components()) {
    EXPECT_EQ(plan::RequestFor(SceneOf(""), info.component),
              info.is_in_auto ? plan::PruningRequest::kAuto : plan::PruningRequest::kNo);
    EXPECT_EQ(plan::RequestFor(SceneOf("omit none"), info.component), plan::PruningRequest::kNo);
    EXPECT_EQ(plan::RequestFor(SceneOf("omit pools"), info.component),
              info.component == schema::Component::kPools ? plan::PruningRequest::kByName
                                                          : plan::PruningRequest::kNo);
  }
}

TEST(RequestFor, TakesNamesBesideAuto) {
  const plan::Scene scene = SceneOf("omit auto, wall_pairs; pair_order sorted");
  using schema::Component;
  EXPECT_EQ(plan::RequestFor(scene, Component::kWallPairs), plan::PruningRequest::kByName);
  EXPECT_EQ(plan::RequestFor(scene, Component::kWalls), plan::PruningRequest::kAuto);
  EXPECT_FALSE(schema::InfoOf(Component::kWallPairs).is_in_auto);
  EXPECT_TRUE(schema::InfoOf(Component::kWallPairs).IsVisible());
}

TEST(DecisionsText, SaysEveryFate) {
  EXPECT_EQ(plan::DecisionsText({}), "");
  const plan::PruningDecision decisions[] = {
      {schema::Component::kWalls, plan::Decision::kOpen, "later"},
      {schema::Component::kRaycastTree, plan::Decision::kAbsent, "dbvt has none"},
      {schema::Component::kGravity, plan::Decision::kKept, "the acceleration is 1"},
      {schema::Component::kPools, plan::Decision::kLeftOut, "room for 3: plenty"}};
  EXPECT_EQ(plan::DecisionsText(decisions),
            "walls: open: later\nraycast_tree: none: dbvt has none\n"
            "gravity: kept: the acceleration is 1\npools: left out: room for 3: plenty\n");
}

TEST(OmittedNames, AreThoseLeftOut) {
  EXPECT_EQ(plan::OmittedNames({}), "");
  EXPECT_EQ(plan::OmittedNames(plan::AnalysePruning(SceneOf("omit none"))), "");
  EXPECT_EQ(
      plan::OmittedNames(plan::AnalysePruning(SceneOf("detector sap; omit raycast_tree, gravity\n"
                                                      "acceleration 0"))),
      "raycast_tree gravity");
}

// They go through shared memory of a fixed size (runtime/measure/recording.h).
TEST(OmittedNames, OfAllComponentsFitTheRecording) {
  std::vector<plan::PruningDecision> decisions;
  for (const schema::ComponentInfo& info : schema::Components())
    decisions.push_back({info.component, plan::Decision::kLeftOut, ""});
  EXPECT_LT(plan::OmittedNames(decisions).size(), 256u);
}

}  // namespace
}  // namespace cdb::tests
