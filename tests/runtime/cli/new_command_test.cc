// `cdb new`: every template compiles, and nothing is overwritten.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "dsl/format.h"
#include "runtime/cli/help/first_scene.h"
#include "runtime/cli/options/inputs.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

using testing::HasSubstr;

TEST(New, EveryTemplateCompilesAndIsFormatted) {
  for (const help::SceneWord& compared : help::SceneTemplates())
    for (const help::SceneWord& objects : help::SceneObjects())
      for (const std::uint64_t quantity : {0, 1, 7, 1000}) {
        const std::string text =
            help::SceneText({std::string(compared.word), std::string(objects.word), quantity},
                            "scene", "scene.cdb");
        EXPECT_EQ(dsl::Format(text::Source("scene.cdb", text)), text);
        const auto read = [&text](const std::string&, std::string&) { return std::optional(text); };
        const auto made = options::CompileWith("scene.cdb", read, std::nullopt);
        // Of a few objects, some scenes bounce in a way that Bullet may not compute well.
        EXPECT_FALSE(made.diagnostics.has_errors()) << text << dsl::Render(made.diagnostics);
        EXPECT_TRUE(quantity > 0 || made.diagnostics.all().empty())
            << text << dsl::Render(made.diagnostics);
        EXPECT_EQ(made.plans.size(), 1u);
      }
}

TEST(New, WritesAFileThatRuns) {
  const Program program;
  const Finished made = program.Run({"new"});
  EXPECT_EQ(made.status, 0) << made.err;
  EXPECT_THAT(made.out, HasSubstr("cdb run scene.cdb\n"));
  EXPECT_EQ(
      program.Run({"new", "my", "--template", "error", "--objects", "mixed", "--quantity", "2"})
          .status,
      0);
  EXPECT_EQ(program.Run({"run", "my.cdb", "-q"}).status, 0);
  EXPECT_EQ(program.Run({"show", "my.cdb", "--error", "energy"}).status, 0);
  const std::string before = program.Read("my.cdb");
  const Finished again = program.Run({"new", "my.cdb"});
  EXPECT_EQ(again.status, 2);
  EXPECT_THAT(again.err, HasSubstr("'my.cdb' exists and was not changed"));
  EXPECT_EQ(program.Read("my.cdb"), before);
  EXPECT_EQ(program.Run({"new", "two words.cdb", "--objects", "spheres"}).status, 0);
  EXPECT_EQ(program.Run({"check", "two words.cdb"}).status, 0);
  EXPECT_THAT(program.Run({"new", "x", "--template", "eror"}).err, HasSubstr("did you mean"));
  EXPECT_EQ(program.Run({"new", "x.h5"}).status, 2);
  EXPECT_THAT(program.Run({"new", "--list"}).out, HasSubstr("--objects mesh"));
}

TEST(New, AsksUntilAnAnswerCanBeUsed) {
  const auto choose = [](std::vector<std::string> answers) {
    std::size_t next = 0;
    const auto choice = help::AskForScene([&](const std::string&) -> std::optional<std::string> {
      return next < answers.size() ? std::optional(answers[next++]) : std::nullopt;
    });
    return choice ? fmt::format("{} {} {}", choice->objects, choice->compared, choice->quantity)
                  : std::string("nothing");
  };
  EXPECT_EQ(choose({"", "", ""}), "boxes detectors 200");
  EXPECT_EQ(choose({"cats", "mesh", "scaling", ""}), "mesh scaling 100");
  EXPECT_EQ(choose({"spheres", "error", "0", "-1", "many", "12"}), "spheres error 12");
  EXPECT_EQ(choose({"spheres", "error"}), "nothing");
  EXPECT_EQ(choose({}), "nothing");
}

}  // namespace
}  // namespace cdb::tests
