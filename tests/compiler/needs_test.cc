// What of the engine a run leaves out, as far as its numbers tell.
#include "compiler/needs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "compiler/schema.h"
#include "dsl/render.h"
#include "tests/compiler/memory_files.h"

namespace cdb::compiler {
namespace {

/// The scene of a benchmark with these statements.
Scene SceneOf(const std::string& statements) {
  const Compilation result = CompileText("benchmark b {\n" + statements + "\n}\n");
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
  return result.plans.empty() ? Scene() : result.plans[0].runs.at(0).scene;
}

const Need& NeedOf(const std::vector<Need>& needs, Component component) {
  return needs.at(static_cast<std::size_t>(component));
}

TEST(Components, AreOneRowEachInTheOrderOfTheEnum) {
  std::set<std::string_view> names;
  int index = 0;
  for (const ComponentInfo& info : Components()) {
    EXPECT_EQ(static_cast<int>(info.component), index++) << info.name;
    EXPECT_EQ(&InfoOf(info.component), &info);
    EXPECT_EQ(FindComponent(info.name), &info);
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    EXPECT_FALSE(info.doc.empty()) << info.name;
    EXPECT_EQ(info.IsVisible(), !info.changes.empty()) << info.name;
    // A word of the language: a letter, then letters, digits and _.
    EXPECT_EQ(info.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz_"), std::string_view::npos);
    EXPECT_TRUE(info.name != "auto" && info.name != "none");
  }
  EXPECT_EQ(index, static_cast<int>(Component::kPools) + 1);
  EXPECT_EQ(FindComponent("gyro"), nullptr);
  EXPECT_EQ(FindComponent(""), nullptr);
}

struct Row {
  Component component;
  const char* statements;
  Fate fate;
  const char* why;  ///< a part of the reason
};

const Row kRows[] = {
    {Component::kWalls, "", Fate::kOpen, "all are placed"},
    {Component::kWalls, "world.walls floor", Fate::kOpen, "all are placed"},
    {Component::kWalls, "world.walls none", Fate::kAbsent, "none stand"},
    {Component::kWalls, "world.walls none; objects.ccd on", Fate::kAbsent, "none stand"},
    {Component::kWalls, "objects.ccd on", Fate::kKept, "objects have ccd"},
    {Component::kWalls, "objects stones { ccd any(on, off) }", Fate::kKept, "stones have ccd"},
    {Component::kWalls, "objects a { quantity 3 }\nobjects b { quantity 0; ccd on }", Fate::kOpen,
     "all are placed"},

    {Component::kWalls, "objects.links.type ball", Fate::kKept, "objects are linked"},
    {Component::kWalls, "objects a { quantity 0; links.type ball } objects b { }", Fate::kOpen,
     "all are placed"},

    {Component::kRaycastTree, "detector sap", Fate::kLeftOut, "no object has ccd"},
    {Component::kRaycastTree, "detector sap32", Fate::kLeftOut, "no object has ccd"},
    {Component::kRaycastTree, "detector sap32; objects.ccd on", Fate::kKept, "objects have ccd"},
    {Component::kRaycastTree, "detector dbvt", Fate::kAbsent, "dbvt has none"},
    {Component::kRaycastTree, "detector simple; objects.ccd on", Fate::kAbsent, "simple has none"},

    {Component::kDetection, "", Fate::kKept, "record timing asks"},
    {Component::kDetection, "record counts", Fate::kKept, "record counts asks"},
    {Component::kDetection, "record contacts, poses", Fate::kKept, "record contacts asks"},
    {Component::kDetection, "record poses, energy, stability, memory", Fate::kOpen, "can touch"},
    {Component::kDetection, "record poses; objects.ccd on", Fate::kKept, "objects have ccd"},
    {Component::kDetection, "omit detection", Fate::kOpen, "can touch"},

    {Component::kSolver, "", Fate::kOpen, "can touch"},
    {Component::kSolver, "objects.ccd on", Fate::kKept, "objects have ccd"},
    {Component::kSolver, "objects chain { links { type spring } }", Fate::kKept,
     "chain are linked"},

    {Component::kSleeping, "sleeping on", Fate::kOpen, "come to rest"},
    {Component::kSleeping, "sleeping off", Fate::kAbsent, "sleeping is off"},

    {Component::kSweptContacts, "", Fate::kLeftOut, "no object has ccd"},
    {Component::kSweptContacts, "objects.ccd on", Fate::kKept, "objects have ccd"},

    {Component::kGravity, "", Fate::kKept, "(0, -9.8, 0)"},
    {Component::kGravity, "acceleration 0", Fate::kLeftOut, "the acceleration is 0"},
    {Component::kGravity, "acceleration (0, 0, 1e-300)", Fate::kKept, "(0, 0, 1e-300)"},
    {Component::kGravity, "acceleration normal(0, 1)", Fate::kKept, "normal(0, 1)"},
    {Component::kGravity, "acceleration rotating((0, -9.8, 0), (0, 0, 1), 4)", Fate::kKept,
     "the acceleration is rotating((0, -9.8, 0), (0, 0, 1), 4)"},
    {Component::kGravity, "acceleration every(60, 0)", Fate::kKept, "every(60, (0, 0, 0))"},

    {Component::kDamping, "", Fate::kLeftOut, "no object is damped"},
    {Component::kDamping, "objects.linear_damping 0.1", Fate::kKept, "objects have linear_damping"},
    {Component::kDamping, "objects a { } objects b { angular_damping uniform(0, 1) }", Fate::kKept,
     "b have angular_damping"},
    {Component::kDamping, "objects.quantity 0; objects.angular_damping 1", Fate::kLeftOut,
     "no object is damped"},

    {Component::kRotation, "", Fate::kOpen, "set an object spinning"},
    {Component::kRotation, "objects.links.type ball", Fate::kKept, "objects are linked"},
    {Component::kRotation, "objects.angular_velocity (0, 1, 0)", Fate::kKept,
     "objects have angular_velocity"},
    {Component::kRotation, "objects.angular_velocity uniform(-1, 1)", Fate::kKept,
     "objects have angular_velocity"},
    {Component::kRotation, "objects.angular_velocity every(60, 0)", Fate::kKept,
     "objects have angular_velocity"},

    {Component::kMotionStates, "", Fate::kLeftOut, "draws the scene"},
    {Component::kMotionStates, "objects.ccd on", Fate::kLeftOut, "draws the scene"},

    {Component::kStaticBoxes, "detector sap; sleeping off", Fate::kLeftOut, "stay where they are"},
    {Component::kStaticBoxes, "detector sap; sleeping on", Fate::kOpen, "falls asleep"},
    {Component::kStaticBoxes, "detector dbvt; sleeping off", Fate::kKept, "dbvt finds other pairs"},

    {Component::kPools, "", Fate::kOpen, "how many contacts"},
};

TEST(AnalyseNeeds, DecidesByTheNumbers) {
  std::set<std::pair<Component, Fate>> seen;
  for (const Row& row : kRows) {
    const auto needs = AnalyseNeeds(SceneOf(row.statements));
    ASSERT_EQ(needs.size(), Components().size());
    const Need& need = NeedOf(needs, row.component);
    EXPECT_EQ(need.component, row.component);
    EXPECT_EQ(need.fate, row.fate) << InfoOf(row.component).name << " in " << row.statements;
    EXPECT_NE(need.why.find(row.why), std::string::npos) << need.why << " in " << row.statements;
    seen.emplace(row.component, need.fate);
  }
  for (const ComponentInfo& info : Components())
    EXPECT_TRUE(
        std::ranges::any_of(seen, [&](const auto& pair) { return pair.first == info.component; }))
        << info.name << " is in no row";
}

TEST(AnalyseNeeds, NoneKeepsEverything) {
  for (const Need& need : AnalyseNeeds(SceneOf("omit none; world.walls none; sleeping off"))) {
    EXPECT_EQ(need.fate, Fate::kKept);
    EXPECT_EQ(need.why, "omit none");
  }
}

TEST(AnalyseNeeds, AListKeepsWhatItDoesNotName) {
  const auto needs = AnalyseNeeds(SceneOf("detector sap; omit raycast_tree, walls"));
  for (const Need& need : needs) {
    if (need.component == Component::kWalls) {
      EXPECT_EQ(need.fate, Fate::kOpen);
    } else if (need.component == Component::kRaycastTree) {
      EXPECT_EQ(need.fate, Fate::kLeftOut);
    } else {
      EXPECT_EQ(need.fate, Fate::kKept);
      EXPECT_EQ(need.why, "omit does not list it");
    }
  }
}

TEST(HowAsked, IsByAutoByNameOrNotAtAll) {
  for (const ComponentInfo& info : Components()) {
    EXPECT_EQ(HowAsked(SceneOf(""), info.component), Asked::kAuto);
    EXPECT_EQ(HowAsked(SceneOf("omit none"), info.component), Asked::kNo);
    EXPECT_EQ(HowAsked(SceneOf("omit pools"), info.component),
              info.component == Component::kPools ? Asked::kByName : Asked::kNo);
  }
}

TEST(NeedsText, SaysEveryFate) {
  EXPECT_EQ(NeedsText({}), "");
  const Need needs[] = {{Component::kWalls, Fate::kOpen, "later"},
                        {Component::kRaycastTree, Fate::kAbsent, "dbvt has none"},
                        {Component::kGravity, Fate::kKept, "the acceleration is 1"},
                        {Component::kPools, Fate::kLeftOut, "room for 3: plenty"}};
  EXPECT_EQ(NeedsText(needs),
            "walls: open: later\nraycast_tree: none: dbvt has none\n"
            "gravity: kept: the acceleration is 1\npools: left out: room for 3: plenty\n");
}

TEST(OmittedNames, AreThoseLeftOut) {
  EXPECT_EQ(OmittedNames({}), "");
  EXPECT_EQ(OmittedNames(AnalyseNeeds(SceneOf("omit none"))), "");
  EXPECT_EQ(OmittedNames(AnalyseNeeds(SceneOf("detector sap; omit raycast_tree, gravity\n"
                                              "acceleration 0"))),
            "raycast_tree gravity");
}

// They go through shared memory of a fixed size (runtime/measure/recording.h).
TEST(OmittedNames, OfAllComponentsFitTheRecording) {
  std::vector<Need> needs;
  for (const ComponentInfo& info : Components())
    needs.push_back({info.component, Fate::kLeftOut, ""});
  EXPECT_LT(OmittedNames(needs).size(), 256u);
}

}  // namespace
}  // namespace cdb::compiler
