// The numbers of an object that are computed from other numbers of the same object.
#include "library/distributions/object_numbers.h"

#include <gtest/gtest.h>

#include <cmath>

#include "compiler/schema/formula.h"
#include "library/layouts/initial_state.h"
#include "library/scene_error.h"
#include "tests/support/scene.h"

namespace cdb::tests {
namespace {

using schema::Call;
using schema::Formula;
using schema::Value;

Value Name(const std::string& setting) {
  Formula formula;
  formula.setting = setting;
  return formula;
}

Value Of(const std::string& op, std::vector<Value> arguments) {
  Formula formula;
  formula.op = op;
  formula.arguments = std::move(arguments);
  return formula;
}

plan::Scene DrawnScene(std::uint64_t quantity) {
  plan::Scene scene = DefaultScene(quantity, 500);
  SetGroup(scene, "size", Call{"same", {Uniform(1.0, 5.0)}});
  SeedStreams(scene);
  return scene;
}

std::string RefusalOf(const plan::Scene& scene) {
  try {
    layouts::DrawObjects(scene);
  } catch (const library::SceneError& error) {
    return error.what();
  }
  return "";
}

TEST(ObjectNumbers, FormulaeAreEvaluatedForEachObject) {
  plan::Scene scene = DrawnScene(50);
  SetGroup(scene, "mass", Of("*", {2.0, Of("^", {Name("size"), 3.0})}));
  SetGroup(scene, "friction", Of("min", {0.5, Of("/", {1.0, Name("mass")})}));
  SetGroup(scene, "restitution", Of("+", {1.0, Of("-", {Of("sqrt", {0.25})})}));
  for (const layouts::ObjectState& object : layouts::DrawObjects(scene).objects) {
    const double size = object.solid.sides.x();
    EXPECT_EQ(object.mass, 2 * std::pow(size, 3));
    EXPECT_EQ(object.numbers["friction"], std::min(0.5, 1 / object.mass));
    EXPECT_EQ(object.numbers["restitution"], 0.5);
  }
}

TEST(ObjectNumbers, TheOtherDrawsStayWhatTheyAre) {
  plan::Scene scene = DrawnScene(20);
  SetGroup(scene, "linear_velocity", Normal(0.0, 1.0));
  SeedStreams(scene);
  const auto before = layouts::DrawObjects(scene).objects;
  SetGroup(scene, "mass", Name("size"));
  const auto after = layouts::DrawObjects(scene).objects;
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(before[i].solid.sides, after[i].solid.sides);
    EXPECT_EQ(before[i].linear_velocity, after[i].linear_velocity);
    EXPECT_EQ(after[i].mass, after[i].solid.sides.x());
  }
}

TEST(ObjectNumbers, ASizeFromAFormulaIsThatOfAllSides) {
  plan::Scene scene = DefaultScene(10, 500);
  SetGroup(scene, "mass", Uniform(1.0, 2.0));
  SetGroup(scene, "size", Of("*", {3.0, Name("mass")}));
  SeedStreams(scene);
  for (const layouts::ObjectState& object : layouts::DrawObjects(scene).objects)
    EXPECT_EQ(object.solid.sides, Eigen::Vector3d::Constant(3 * object.mass));
}

TEST(ObjectNumbers, AMassFromADensityMayBeNamed) {
  plan::Scene scene = DrawnScene(10);
  SetGroup(scene, "mass", Call{"density", {Of("*", {100.0, Name("size")})}});
  SetGroup(scene, "contact_stiffness", Of("*", {1000.0, Name("mass")}));
  for (const layouts::ObjectState& object : layouts::DrawObjects(scene).objects) {
    EXPECT_EQ(object.mass, 100 * object.solid.sides.x() * object.solid.Volume());
    EXPECT_EQ(object.numbers["contact_stiffness"], 1000 * object.mass);
  }
}

TEST(ObjectNumbers, WhatIsNoValueOfTheSettingIsRefused) {
  plan::Scene scene = DrawnScene(50);
  SetGroup(scene, "mass", Of("-", {1.0, Name("size")}));
  EXPECT_NE(RefusalOf(scene).find(
                "the mass of object 1 of `objects` must be more than 0, but 1 - size is -"),
            std::string::npos)
      << RefusalOf(scene);
  scene = DrawnScene(50);
  SetGroup(scene, "friction", Of("sqrt", {Of("-", {Name("size")})}));
  EXPECT_NE(RefusalOf(scene).find("sqrt(-size) is no finite number"), std::string::npos);
  scene = DrawnScene(50);
  SetGroup(scene, "mass", Word("fixed"));
  SetGroup(scene, "friction", Name("mass"));
  EXPECT_NE(RefusalOf(scene).find("`objects.mass` is not a number for object 1"),
            std::string::npos);
}

// The plan is written by hand, because the compiler rejects such settings.
TEST(ObjectNumbers, CirclesEnd) {
  plan::Scene scene = DrawnScene(5);
  SetGroup(scene, "mass", Name("friction"));
  SetGroup(scene, "friction", Name("mass"));
  EXPECT_NE(RefusalOf(scene).find("depends on itself"), std::string::npos);
  scene = DrawnScene(5);
  SetGroup(scene, "mass", Call{"density", {1000.0}});
  SetGroup(scene, "size", Name("mass"));
  EXPECT_NE(RefusalOf(scene).find("which a density gives"), std::string::npos);
  scene = DrawnScene(5);
  SetGroup(scene, "size", Uniform(1.0, 5.0));
  SetGroup(scene, "mass", Name("size"));
  EXPECT_NE(RefusalOf(scene).find("draws each side separately"), std::string::npos);
}

}  // namespace
}  // namespace cdb::tests
