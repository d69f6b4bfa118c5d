// Properties that every benchmark has, tested with random ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include "compiler/yaml/plan_yaml.h"
#include "dsl/diagnostics.h"
#include "dsl/format.h"
#include "tests/compiler/random_scenario.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

constexpr int kScenarios = 150;

plan::Plan PlanOfScenario(const std::string& text) {
  compiler::Compilation result =
      CompileText(text, {{kModelFile, "v 0 0 0"}, {kHeightsFile, "0,1"}});
  EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics) << text;
  return result.plans.empty() ? plan::Plan() : std::move(result.plans[0]);
}

TEST(Property, AGridIsTheProductOfItsAxes) {
  std::mt19937_64 random(1);
  for (int i = 0; i < kScenarios; ++i) {
    const RandomScenario scenario = MakeRandomScenario(random);
    const plan::Plan plan = PlanOfScenario(scenario.Text());
    EXPECT_EQ(plan.runs.size(), scenario.points * plan.repeats) << scenario.Text();
    std::set<std::pair<std::vector<std::size_t>, std::uint64_t>> places;
    for (const plan::Run& run : plan.runs) {
      EXPECT_TRUE(places.insert({run.at, run.rep}).second);
      EXPECT_EQ(run.id, plan::RunId(run.scene, run.rep));
    }
  }
}

TEST(Property, YamlReadsBackAsThePlan) {
  std::mt19937_64 random(2);
  for (int i = 0; i < kScenarios / 3; ++i) {
    const plan::Plan plan = PlanOfScenario(MakeRandomScenario(random).Text());
    EXPECT_TRUE(yaml::FromYaml(yaml::ToYaml(plan), "plan") == plan) << plan.scenario_text;
  }
}

TEST(Property, OrderOfStatementsMovesOnlyAxes) {
  std::mt19937_64 random(3);
  for (int i = 0; i < kScenarios / 3; ++i) {
    RandomScenario scenario = MakeRandomScenario(random);
    const auto ids = [](const plan::Plan& plan) {
      std::multiset<std::string> all;
      for (const plan::Run& run : plan.runs) all.insert(run.id);
      return all;
    };
    const auto before = ids(PlanOfScenario(scenario.Text()));
    std::ranges::shuffle(scenario.settings, random);
    EXPECT_EQ(before, ids(PlanOfScenario(scenario.Text()))) << scenario.Text();
  }
}

TEST(Property, LayoutOfTheTextHasNoMeaning) {
  std::mt19937_64 random(4);
  for (int i = 0; i < kScenarios / 3; ++i) {
    const std::string text = MakeRandomScenario(random).Text();
    const std::string formatted = dsl::Format(text::Source("test.cdb", text));
    EXPECT_EQ(PlanOfScenario(text).Sha256(), PlanOfScenario(formatted).Sha256()) << text;
  }
}

TEST(Property, ALetIsTheSameAsItsValue) {
  std::mt19937_64 random(5);
  for (int i = 0; i < kScenarios / 3; ++i) {
    const RandomScenario scenario = MakeRandomScenario(random);
    std::string text, inner;
    for (std::size_t s = 0; s < scenario.settings.size(); ++s) {
      const std::string& setting = scenario.settings[s];
      const std::size_t space = setting.find(' ');
      // A let cannot hold a list, and in a let `sleeping` means the switch.
      if (setting.starts_with("record") || setting.starts_with("omit") ||
          setting.starts_with("accuracy.metrics")) {
        inner += setting + "\n";
        continue;
      }
      text += "let v" + std::to_string(s) + " = " + setting.substr(space + 1) + "\n";
      inner += setting.substr(0, space) + " v" + std::to_string(s) + "\n";
    }
    const plan::Plan direct = PlanOfScenario(scenario.Text());
    const plan::Plan by_let = PlanOfScenario(text + "benchmark b {\n" + inner + "}\n");
    // The axis of a let comes before that of a list, which stays where it is.
    const auto ids = [](const plan::Plan& plan) {
      std::vector<std::string> all;
      for (const plan::Run& run : plan.runs) all.push_back(run.id);
      std::ranges::sort(all);
      return all;
    };
    EXPECT_EQ(ids(direct), ids(by_let)) << text << inner;
  }
}

/// Adds a fault to a setting.
std::string Planted(const std::string& setting, std::mt19937_64& random) {
  const std::size_t space = setting.find(' ');
  const std::string name = setting.substr(0, space), value = setting.substr(space + 1);
  switch (random() % 8) {
    case 0:
      return name;
    case 1:
      return name + " 1 : 2";
    case 2:
      return name + " (1, 2";
    case 3:
      return name + " = " + value;
    case 4:
      return name + " 1 + / 2";
    case 5:
      return name + " frobnicate(3)";
    case 6:
      return name + "_frobnicate " + value;
    default:
      return name + " " + value + ")";
  }
}

TEST(Property, EachPlantedFaultIsReportedOnce) {
  std::mt19937_64 random(6);
  for (int i = 0; i < kScenarios; ++i) {
    RandomScenario scenario = MakeRandomScenario(random);
    std::vector<std::size_t> order(scenario.settings.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::shuffle(order, random);
    const std::size_t n = std::min<std::size_t>(order.size(), 1 + random() % 10);
    for (std::size_t k = 0; k < n; ++k)
      scenario.settings[order[k]] = Planted(scenario.settings[order[k]], random);
    const compiler::Compilation compilation =
        CompileText(scenario.Text(), {{kModelFile, "v 0 0 0"}, {kHeightsFile, "0,1"}});
    EXPECT_EQ(compilation.diagnostics.error_count(), static_cast<int>(n))
        << scenario.Text() << dsl::Render(compilation.diagnostics);
  }
}

}  // namespace
}  // namespace cdb::tests
