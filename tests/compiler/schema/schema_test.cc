#include "compiler/schema/schema.h"

#include <gtest/gtest.h>

#include <set>

#include "compiler/analysis/pruning.h"
#include "compiler/plan/plan.h"
#include "compiler/schema/catalogue.h"
#include "compiler/schema/parametrised_words.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

TEST(Schema, NamesAreUniqueAndDocumented) {
  std::set<std::string> names;
  for (const schema::Parameter& parameter : schema::Schema()) {
    EXPECT_TRUE(names.insert(parameter.FullName()).second) << parameter.name;
    EXPECT_FALSE(parameter.doc.empty()) << parameter.name;
    EXPECT_EQ(schema::FindParameter(parameter.name, parameter.grouped), &parameter);
  }
  EXPECT_EQ(schema::FindParameter("colour", false), nullptr);
}

TEST(Schema, EveryDefaultIsAValueOfItsParameter) {
  const compiler::Compilation result = CompileText("benchmark b { }");
  ASSERT_EQ(result.plans.size(), 1u);
  const plan::Scene& scene = result.plans[0].runs[0].scene;
  for (const schema::Parameter& parameter : schema::Schema()) {
    const bool is_stated =
        parameter.grouped ? scene.groups[0].settings.Has(parameter) : scene.world.Has(parameter);
    // As the compiler evaluates it, so does a plan without it.
    const bool must_be = plan::ValueIfAbsent(parameter) == nullptr ||
                         parameter.DefaultText() != parameter.first_default;
    EXPECT_EQ(is_stated, must_be) << parameter.name;
  }
}

TEST(Schema, ReferenceRunsSetParametersThatExist) {
  for (const schema::Parameter& parameter : schema::Schema())
    EXPECT_TRUE(parameter.of_reference.empty() ||
                schema::FindParameter(parameter.of_reference, false) != nullptr)
        << parameter.name;
}

// Woulfe & Manzke 2009, section 3.1: the ten parameters and their defaults, and the seed.
TEST(Schema, DefaultsAreThePapers) {
  const compiler::Compilation result = CompileText("benchmark b { }");
  ASSERT_EQ(result.plans.size(), 1u);
  const plan::Scene& scene = result.plans[0].runs[0].scene;
  const plan::GroupSettings& objects = scene.groups[0].settings;
  EXPECT_EQ(scene.world.Count("cycles"), 1000u);
  EXPECT_EQ(objects.Count("quantity"), 10u);
  EXPECT_EQ(objects.WordOr("type"), "sphere");
  EXPECT_EQ(objects.Get("aspect"), schema::Value(schema::Ratio{{1, 1, 1}}));
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
  const schema::Parameter& detector = *schema::WorldParameter("detector");
  const schema::Parameter& narrow_phase = *schema::WorldParameter("narrow_phase");
  for (const auto& row : schema::Detectors()) {
    EXPECT_EQ(detector.HasWord(row.name), row.HasPhase("broad")) << row.name;
    EXPECT_EQ(narrow_phase.HasWord(row.name), row.HasPhase("narrow")) << row.name;
  }
  EXPECT_FALSE(detector.HasWord("sphere"));
}

TEST(Schema, OmitTakesEveryComponent) {
  const schema::Parameter& omit = *schema::WorldParameter("omit");
  for (const schema::ComponentInfo& info : schema::Components()) {
    EXPECT_TRUE(omit.HasWord(info.name)) << info.name;
    EXPECT_FALSE(omit.StandsAlone(info.name)) << info.name;
  }
  EXPECT_TRUE(omit.StandsAlone("auto") && omit.StandsAlone("none"));
  EXPECT_TRUE(omit.StandsBeside("auto", "wall_pairs"));
  for (const auto& [word, other] : {std::pair{"auto", "walls"},
                                    {"auto", "none"},
                                    {"auto", "wall"},
                                    {"none", "wall_pairs"},
                                    {"wall_pairs", "auto"}})
    EXPECT_FALSE(omit.StandsBeside(word, other)) << word << " " << other;
  EXPECT_EQ(omit.Takes().find("auto, none, or a list of walls, raycast_tree, "), 0u)
      << omit.Takes();
  EXPECT_FALSE((*schema::WorldParameter("timeout")).StandsAlone("none"));
}

TEST(Schema, BlocksFollowFromItsNames) {
  using Blocks = std::vector<std::string_view>;
  EXPECT_EQ(schema::BlocksIn("", true), Blocks({"links", "spawn", "remove", "soft"}));
  EXPECT_EQ(schema::BlocksIn("links", true), Blocks());
  EXPECT_EQ(schema::BlocksIn("joints", true), Blocks({"gear", "limits", "motor"}));
  const Blocks of_world = schema::BlocksIn("", false);
  for (const std::string_view block : {"world", "solver"})
    EXPECT_EQ(std::ranges::count(of_world, block), 1) << block;
  EXPECT_EQ(schema::BlocksIn("world", false), Blocks());
  EXPECT_EQ(schema::BlocksIn("links", false), Blocks());
}

TEST(ParametrisedWords, AreDocumentedAndTakenBySomething) {
  std::set<std::string_view> names;
  for (const schema::ParametrisedWord& info : schema::ParametrisedWords()) {
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    EXPECT_EQ(schema::FindParametrisedWord(info.name), &info);
    EXPECT_FALSE(info.doc.empty() || info.arguments.empty()) << info.name;
    // A call must not be confused with a distribution or a plain word.
    EXPECT_FALSE(schema::FindDistribution(info.name)) << info.name;
    int takers = 0;
    for (const schema::Parameter& parameter : schema::Schema()) {
      EXPECT_FALSE(parameter.TakesCall(info.name) && parameter.HasWord(info.name)) << info.name;
      takers += parameter.TakesCall(info.name);
    }
    const bool is_part = schema::PartParameter().TakesCall(info.name);
    EXPECT_GT(takers + is_part, 0) << info.name;
    bool has_default = false;
    for (const schema::Parameter& argument : info.arguments) {
      EXPECT_FALSE(argument.doc.empty()) << info.name << " " << argument.name;
      EXPECT_TRUE(argument.DefaultText().empty() || argument.HasWord(argument.DefaultText()))
          << info.name << " " << argument.name;
      // Required arguments come first, so that they can be given by position. The hash of a file is
      // second; it is for plans, and what follows is given by name.
      if (argument.name == "sha256") continue;
      EXPECT_FALSE(has_default && argument.DefaultText().empty()) << info.name;
      has_default = !argument.DefaultText().empty();
      EXPECT_TRUE(argument.calls.empty() || is_part) << info.name << " " << argument.name;
    }
  }
  for (const schema::Parameter& parameter : schema::Schema())
    for (const std::string_view call : parameter.AllCalls())
      EXPECT_NE(schema::FindParametrisedWord(call), nullptr) << call;
  EXPECT_EQ(schema::FindParametrisedWord("circle"), nullptr);
}

TEST(ParametrisedWords, AreShownWithWhatTheyNeed) {
  const std::string location = (*schema::GroupParameter("location")).Takes();
  EXPECT_EQ(location,
            "one of uniform, normal, grid, stack, pyramid, pile, ring, line, at( ), pair( ), "
            "relative_to( ), poses( ), path( )");
  EXPECT_EQ((*schema::WorldParameter("acceleration")).Takes(),
            "a vector (x, y, z), or 0, or every( ), or rotating( ), or a distribution");
  EXPECT_EQ(
      schema::ToText(schema::Value(*schema::WithDefaults(*schema::FindParametrisedWord("stack")))),
      "stack");
  EXPECT_FALSE(schema::WithDefaults(*schema::FindParametrisedWord("pair")));
}

TEST(Domain, SaysWhatItContains) {
  const schema::Domain positive = {.min = 0, .min_open = true};
  EXPECT_FALSE(positive.Contains(0));
  EXPECT_TRUE(positive.Contains(1e-300));
  EXPECT_EQ(positive.Text(), "more than 0");
  EXPECT_EQ((schema::Domain{.min = 0, .min_open = true, .max = 2}).Text(),
            "more than 0 and at most 2");
  const schema::Domain part = {.min = 0, .max = 1};
  EXPECT_TRUE(part.Contains(0) && part.Contains(1) && !part.Contains(1.01));
  EXPECT_EQ(part.Text(), "between 0 and 1");
}

}  // namespace
}  // namespace cdb::tests
