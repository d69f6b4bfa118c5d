#include "compiler/plan/settings.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

namespace cdb::tests {
namespace {

using plan::WorldSettings;
using schema::Number;
using schema::Value;
using schema::Word;

WorldSettings Some() {
  WorldSettings settings;
  settings.Set("timestep", Number(0.5));
  settings.Set("cycles", Number(std::uint64_t{7}));
  settings.Set("detector", Word{"sap"});
  return settings;
}

std::string TextOf(const WorldSettings& settings) {
  std::string text;
  for (const auto& [name, value] : settings)
    text += std::string(name) + " " + schema::ToText(value) + "; ";
  return text;
}

TEST(Settings, AreInTheOrderOfTheirNames) {
  EXPECT_EQ(TextOf(Some()), "cycles 7; detector sap; timestep 0.5; ");
  EXPECT_EQ(Some().size(), 3u);
}

TEST(Settings, ACopyIsChangedByItself) {
  WorldSettings settings = Some();
  const WorldSettings copy = settings;
  WorldSettings other = settings;
  settings.Set("cycles", Number(std::uint64_t{8}));
  other.Erase("detector");
  EXPECT_EQ(TextOf(settings), "cycles 8; detector sap; timestep 0.5; ");
  EXPECT_EQ(TextOf(copy), TextOf(Some()));
  EXPECT_EQ(TextOf(other), "cycles 7; timestep 0.5; ");
  EXPECT_EQ(copy, Some());
  EXPECT_NE(settings, copy);
  settings.Set("cycles", Number(std::uint64_t{7}));
  EXPECT_EQ(settings, copy);
}

TEST(Settings, CopiesShareTheValuesInWhichTheyAgree) {
  const WorldSettings settings = Some();
  WorldSettings copy = settings;
  EXPECT_EQ(&copy.Get("timestep"), &settings.Get("timestep"));
  copy.Set("cycles", Number(std::uint64_t{8}));
  EXPECT_EQ(&copy.Get("timestep"), &settings.Get("timestep"));
  EXPECT_NE(&copy.Get("cycles"), &settings.Get("cycles"));
}

TEST(Settings, HoldWhatDiffersFromTheDefaults) {
  WorldSettings settings = Some();
  settings.Set("detector", Word{"dbvt"});
  settings.Set("timestep", 1.0 / 60);
  EXPECT_EQ(TextOf(settings), "cycles 7; ");
  settings.Erase("cycles");
  EXPECT_EQ(settings, WorldSettings());
  EXPECT_EQ(settings.WordOr("detector"), "dbvt");
  EXPECT_EQ(settings.Real("timestep"), 1.0 / 60);
  EXPECT_EQ(settings.Count("cycles"), 1000u);
  EXPECT_EQ(settings.Words("record"), schema::WordList({"counts", "stability", "timing"}));
  // Texts tell -0 from 0.
  plan::GroupSettings objects;
  objects.Set("linear_velocity", Eigen::Vector3d(-0.0, 0, 0));
  EXPECT_TRUE(objects.Has(*schema::GroupParameter("linear_velocity")));
}

TEST(Settings, WhatIsErasedOrMovedAwayIsNotThere) {
  WorldSettings settings = Some();
  settings.Erase("sleeping");
  EXPECT_EQ(settings, Some());
  const WorldSettings moved = std::move(settings);
  EXPECT_EQ(moved, Some());
  EXPECT_EQ(settings.size(), 0u);
  EXPECT_EQ(settings.begin(), settings.end());
}

}  // namespace
}  // namespace cdb::tests
