#include "compiler/schema.h"

#include <gtest/gtest.h>

#include <set>

#include "compiler/calls.h"
#include "compiler/needs.h"
#include "compiler/plan.h"
#include "library/catalogue.h"
#include "tests/compiler/memory_files.h"

namespace cdb::compiler {
namespace {

TEST(Schema, NamesAreUniqueAndDocumented) {
  std::set<std::string> names;
  for (const Parameter& parameter : Schema()) {
    EXPECT_TRUE(names.insert(parameter.FullName()).second) << parameter.name;
    EXPECT_FALSE(parameter.doc.empty()) << parameter.name;
    EXPECT_FALSE(parameter.component.empty()) << parameter.name;
    EXPECT_EQ(FindParameter(parameter.name, parameter.grouped), &parameter);
  }
  EXPECT_EQ(FindParameter("colour", false), nullptr);
}

TEST(Schema, EveryDefaultIsAValueOfItsParameter) {
  const Compilation result = CompileText("benchmark b { }");
  ASSERT_EQ(result.plans.size(), 1u);
  const Scene& scene = result.plans[0].runs[0].scene;
  for (const Parameter& parameter : Schema()) {
    const Settings& settings = parameter.grouped ? scene.groups[0].settings : scene.world;
    EXPECT_TRUE(settings.Has(parameter.name)) << parameter.name;
  }
  EXPECT_EQ(scene.world.values.size() + scene.groups[0].settings.values.size(), Schema().size());
}

// The paper, section 3.1: the ten parameters and their defaults, and the seed.
TEST(Schema, DefaultsAreThePapers) {
  const Compilation result = CompileText("benchmark b { }");
  ASSERT_EQ(result.plans.size(), 1u);
  const Scene& scene = result.plans[0].runs[0].scene;
  const Settings& objects = scene.groups[0].settings;
  EXPECT_EQ(scene.world.Count("cycles"), 1000u);
  EXPECT_EQ(objects.Count("quantity"), 10u);
  EXPECT_EQ(objects.WordOr("type"), "sphere");
  EXPECT_EQ(objects.Get("aspect"), Value(Ratio{{1, 1, 1}}));
  EXPECT_EQ(objects.WordOr("location"), "uniform");
  EXPECT_EQ(objects.Real("size"), 50);
  EXPECT_EQ(objects.Real("mass"), 1);
  EXPECT_EQ(scene.world.Vector("acceleration"), Eigen::Vector3d(0, -9.8, 0));
  EXPECT_EQ(objects.Vector("linear_velocity"), Eigen::Vector3d::Zero());
  EXPECT_EQ(objects.Vector("angular_velocity"), Eigen::Vector3d::Zero());
  EXPECT_EQ(scene.world.Count("seed"), 0xAAAAAAAAAAu);
  EXPECT_EQ(scene.world.Real("world.side"), 500);
}

TEST(Schema, WordsComeFromTheCatalogue) {
  const Parameter& detector = *FindParameter("detector", false);
  const Parameter& narrow_phase = *FindParameter("narrow_phase", false);
  for (const auto& row : library::Detectors()) {
    EXPECT_EQ(detector.HasWord(row.name), row.HasPhase("broad")) << row.name;
    EXPECT_EQ(narrow_phase.HasWord(row.name), row.HasPhase("narrow")) << row.name;
  }
  EXPECT_FALSE(detector.HasWord("sphere"));
}

TEST(Schema, OmitTakesEveryComponent) {
  const Parameter& omit = *FindParameter("omit", false);
  for (const ComponentInfo& info : Components()) {
    EXPECT_TRUE(omit.HasWord(info.name)) << info.name;
    EXPECT_FALSE(omit.StandsAlone(info.name)) << info.name;
  }
  EXPECT_TRUE(omit.StandsAlone("auto") && omit.StandsAlone("none"));
  EXPECT_EQ(omit.Takes().find("auto, none, or a list of walls, raycast_tree, "), 0u)
      << omit.Takes();
  EXPECT_FALSE(FindParameter("timeout", false)->StandsAlone("none"));
}

TEST(Schema, BlocksFollowFromItsNames) {
  using Blocks = std::vector<std::string_view>;
  EXPECT_EQ(BlocksIn("", true), Blocks({"links"}));
  EXPECT_EQ(BlocksIn("links", true), Blocks());
  const Blocks of_world = BlocksIn("", false);
  for (const std::string_view block : {"world", "solver"})
    EXPECT_EQ(std::ranges::count(of_world, block), 1) << block;
  EXPECT_EQ(BlocksIn("world", false), Blocks());
  EXPECT_EQ(BlocksIn("links", false), Blocks());
}

TEST(Calls, AreDocumentedAndTakenBySomething) {
  std::set<std::string_view> names;
  for (const CallInfo& info : Calls()) {
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    EXPECT_EQ(FindCall(info.name), &info);
    EXPECT_FALSE(info.doc.empty() || info.arguments.empty()) << info.name;
    // A call is told from a distribution, and from a word that stands alone.
    EXPECT_FALSE(FindDistribution(info.name)) << info.name;
    int takers = 0;
    for (const Parameter& parameter : Schema()) {
      EXPECT_FALSE(parameter.TakesCall(info.name) && parameter.HasWord(info.name)) << info.name;
      takers += parameter.TakesCall(info.name);
    }
    EXPECT_GT(takers, 0) << info.name;
    bool has_default = false;
    for (const Parameter& argument : info.arguments) {
      EXPECT_FALSE(argument.doc.empty()) << info.name << " " << argument.name;
      EXPECT_TRUE(argument.default_text.empty() || argument.HasWord(argument.default_text))
          << info.name << " " << argument.name;
      // What must be given comes first, so that it can be given by its place.
      EXPECT_FALSE(has_default && argument.default_text.empty()) << info.name;
      has_default = !argument.default_text.empty();
      EXPECT_TRUE(argument.calls.empty()) << info.name << " " << argument.name;
    }
  }
  for (const Parameter& parameter : Schema())
    for (const std::string_view call : parameter.AllCalls())
      EXPECT_NE(FindCall(call), nullptr) << call;
  EXPECT_EQ(FindCall("circle"), nullptr);
}

TEST(Calls, AreShownWithWhatTheyNeed) {
  const std::string location = FindParameter("location", true)->Takes();
  EXPECT_EQ(location,
            "one of uniform, normal, grid, stack, pyramid, pile, ring, line, at( ), pair( )");
  EXPECT_EQ(FindParameter("acceleration", false)->Takes(),
            "a vector (x, y, z), or 0, or every( ), or rotating( ), or a distribution");
  EXPECT_EQ(ToText(Value(*WithDefaults(*FindCall("stack")))), "stack");
  EXPECT_FALSE(WithDefaults(*FindCall("pair")));
}

TEST(Domain, SaysWhatItContains) {
  const Domain positive = {.min = 0, .min_open = true};
  EXPECT_FALSE(positive.Contains(0));
  EXPECT_TRUE(positive.Contains(1e-300));
  EXPECT_EQ(positive.Text(), "more than 0");
  const Domain part = {.min = 0, .max = 1};
  EXPECT_TRUE(part.Contains(0) && part.Contains(1) && !part.Contains(1.01));
  EXPECT_EQ(part.Text(), "between 0 and 1");
}

}  // namespace
}  // namespace cdb::compiler
