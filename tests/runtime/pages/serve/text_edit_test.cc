#include "runtime/pages/serve/text_edit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cdb::tests {
namespace {

using serve::Place;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kEditedScenario = R"(# Kept.
benchmark one { cycles 5 }
benchmark two from one "Title" {
  cycles      sweep(1, 2)   # how many
  world {
    side      10
  }
  objects.mass 3
  objects { quantity 4; size uniform(1, 2) }
  objects pebbles {
    size      0.1
  }
}
)";

std::string Changed(const Place& place, const std::string& value) {
  return serve::WithValue(kEditedScenario, "two", place, value);
}
/// The scenario with `from` replaced.
std::string Expected(const std::string& from, const std::string& to) {
  std::string text = kEditedScenario;
  return text.replace(text.find(from), from.size(), to);
}

TEST(TextEdit, ReadsValuesAsTheyAreWritten) {
  const auto value = [](const Place& place) {
    return serve::WrittenValue(kEditedScenario, "two", place).value_or("none");
  };
  EXPECT_EQ(value({"", "cycles"}), "sweep(1, 2)");
  EXPECT_EQ(value({"", "world.side"}), "10");
  EXPECT_EQ(value({"objects", "mass"}), "3");
  EXPECT_EQ(value({"objects", "size"}), "uniform(1, 2)");
  EXPECT_EQ(value({"pebbles", "size"}), "0.1");
  EXPECT_EQ(value({"pebbles", "mass"}), "none");
  EXPECT_EQ(value({"", "timestep"}), "none");
  EXPECT_THAT(serve::GroupsIn(kEditedScenario, "two"), ElementsAre("objects", "pebbles"));
}

TEST(TextEdit, ChangesOnlyTheValue) {
  EXPECT_EQ(Changed({"", "cycles"}, "7"), Expected("sweep(1, 2)", "7"));
  EXPECT_EQ(Changed({"", "world.side"}, "20"), Expected("side      10", "side      20"));
  EXPECT_EQ(Changed({"objects", "mass"}, "fixed"),
            Expected("objects.mass 3", "objects.mass fixed"));
  EXPECT_EQ(Changed({"pebbles", "size"}, "0.2"), Expected("0.1", "0.2"));
}

TEST(TextEdit, AddsWhatIsNotThereAtTheEndOfItsBlock) {
  EXPECT_EQ(Changed({"", "timestep"}, "1 / 30"),
            Expected("    size      0.1\n  }\n}", "    size      0.1\n  }\n  timestep 1 / 30\n}"));
  EXPECT_EQ(Changed({"objects", "friction"}, "0.2"),
            Expected("uniform(1, 2) }", "uniform(1, 2); friction 0.2 }"));
  EXPECT_EQ(Changed({"pebbles", "mass"}, "9"), Expected("0.1\n", "0.1\n    mass 9\n"));
  EXPECT_EQ(serve::WithValue("benchmark b { }", "b", {"", "cycles"}, "3"),
            "benchmark b { cycles 3 }");
}

TEST(TextEdit, RefusesByName) {
  const auto error = [](const std::string& text, const Place& place, const std::string& value) {
    try {
      serve::WithValue(text, "two", place, value);
    } catch (const serve::EditError& refused) {
      return std::string(refused.what());
    }
    return std::string("no error");
  };
  EXPECT_THAT(error(kEditedScenario, {"", "cycles"}, " "), HasSubstr("cycles needs a value"));
  EXPECT_THAT(error(kEditedScenario, {"", "cycles"}, "3\n} benchmark x {"),
              HasSubstr("on one line"));
  EXPECT_THAT(error("benchmark one { }", {"", "cycles"}, "3"),
              HasSubstr("no longer has a benchmark 'two'"));
  EXPECT_THAT(error(kEditedScenario, {"rocks", "size"}, "3"),
              HasSubstr("does not define the group 'rocks'"));
  EXPECT_THAT(error("benchmark two {", {"", "cycles"}, "3"), HasSubstr("error"));
}

}  // namespace
}  // namespace cdb::tests
