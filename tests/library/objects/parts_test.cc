#include "library/objects/parts.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <numbers>

#include "compiler/yaml/plan_yaml.h"
#include "library/layouts/initial_state.h"
#include "library/objects/solid_factory.h"
#include "library/scene_error.h"
#include "tests/support/compile_text.h"

namespace cdb::tests {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using objects::Solid;

plan::Plan PlanOf(const std::string& type) {
  const auto compiled = CompileText(
      "benchmark b { world.side 50; objects { quantity 1; size native; location at(1, 2, 3); "
      "type " +
      type + " } }");
  EXPECT_FALSE(compiled.diagnostics.has_errors()) << dsl::Render(compiled.diagnostics);
  return compiled.plans.at(0);
}

layouts::ObjectState ObjectOf(const std::string& type) {
  return layouts::MakeInitialState(PlanOf(type).runs.at(0).scene).objects.at(0);
}

/// For 1 kg, along the axes of the compound.
Matrix3d TensorPerMass(const layouts::ObjectState& object) {
  const Matrix3d turn = object.pose.orientation.toRotationMatrix();
  return turn * object.solid.InertiaPerMass().asDiagonal() * turn.transpose();
}

TEST(Compounds, OfPartsHaveTheirMassProperties) {
  // Two cubes of 1 m, one at the origin and one of twice the height beside it.
  const auto object =
      ObjectOf("compound(part(cuboid, (1, 1, 1)), part(cuboid, (1, 2, 1), at: (3, 0, 0)))");
  EXPECT_NEAR(object.solid.Volume(), 3, 1e-12);
  EXPECT_LT((object.pose.position - Vector3d(1 + 2, 2, 3)).norm(), 1e-12) << "2/3 of the way";
  const Vector3d wanted(1.0 / 3 * (1.0 / 6) + 2.0 / 3 * (5.0 / 12),
                        1.0 / 6 + 1.0 / 3 * 4 + 2.0 / 3 * 1,
                        1.0 / 3 * (1.0 / 6 + 4) + 2.0 / 3 * (5.0 / 12 + 1));
  EXPECT_LT((TensorPerMass(object) - Matrix3d(wanted.asDiagonal())).norm(), 1e-12);
  const objects::Box box = objects::Bounds(object.solid, object.pose.orientation);
  EXPECT_LT((object.pose.position + box.lower - Vector3d(0.5, 1, 2.5)).norm(), 1e-12);
  EXPECT_LT((object.pose.position + box.upper - Vector3d(4.5, 3, 3.5)).norm(), 1e-12);
}

TEST(Compounds, TakeAnInertiaAsGiven) {
  const auto object = ObjectOf(
      "compound(part(cuboid, (1, 1, 1)), centre: (0.25, 0, 0.5), inertia: (0.3, 0.4, 0.5), "
      "products: "
      "(0.02, -0.03, 0.04))");
  EXPECT_LT((object.pose.position - Vector3d(1.25, 2, 3.5)).norm(), 1e-12);
  Matrix3d wanted;
  wanted << 0.3, 0.02, -0.03, 0.02, 0.4, 0.04, -0.03, 0.04, 0.5;
  EXPECT_LT((TensorPerMass(object) - wanted).norm(), 1e-12) << TensorPerMass(object);
  const objects::Box box = objects::Bounds(object.solid, object.pose.orientation);
  EXPECT_LT((object.pose.position + box.lower - Vector3d(0.5, 1.5, 2.5)).norm(), 1e-12);
}

TEST(Compounds, HaveRoundPartsWithCornersOnTheSurface) {
  for (const char* type : {"sphere", "cylinder", "cone", "capsule", "tetrahedron", "cuboid"}) {
    const Vector3d sides(2, 3, 2);
    const auto object =
        ObjectOf(fmt::format("compound(part({}, (2, 3, 2), turn: (0, 0, pi / 2)))", type));
    const Solid whole{objects::ShapeOf(type), sides};
    EXPECT_NEAR(object.solid.Volume(), whole.Volume(), 1e-12) << type;
    // y of the part is -x of the compound.
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitZ()));
    const Eigen::Quaterniond in_body = object.pose.orientation.conjugate() * turn;
    for (int i = 0; i < 200; ++i) {
      const Vector3d way =
          Vector3d(std::sin(i), std::cos(2.3 * i), std::sin(1.7 * i + 1)).normalized();
      const double reach = way.dot(whole.Support(way)),
                   found = (in_body * way).dot(object.solid.Support(in_body * way));
      EXPECT_LE(found, reach + 1e-9) << type;
      EXPECT_GE(found, reach - 0.02 * sides.maxCoeff()) << type;
    }
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {-1.0, 1.0}) {
        const Vector3d way = sign * Vector3d::Unit(axis);
        EXPECT_NEAR((in_body * way).dot(object.solid.Support(in_body * way)),
                    way.dot(whole.Support(way)), 1e-9)
            << type << " " << way.transpose();
      }
  }
}

TEST(Compounds, AreReadBackFromPlans) {
  const plan::Plan plan = PlanOf(
      "compound(part(sphere, (1, 1, 1)), part(cylinder, (1, 2, 1), at: (0, 1, 0), turn: (0.1, 0, "
      "0), "
      "scale: (1, -2, 1)), inertia: (1, 1, 1))");
  EXPECT_EQ(yaml::FromYaml(yaml::ToYaml(plan), "plan.yaml"), plan);
}

TEST(Compounds, AreRefusedByName) {
  const std::pair<const char*, const char*> cases[] = {
      {"compound", "'compound' needs part"},
      {"compound()", "needs a part"},
      {"compound(5)", "'part' takes one of part( ), but this is the number 5"},
      {"compound(part(cuboid))", "a part of type cuboid has no sides"},
      {"compound(part(cuboid, (1, 1, 0)))", "a part of type cuboid has no sides"},
      {"compound(part(bunny, (1, 1, 1)))", "'type' cannot be 'bunny'"},
      {"compound(part(cuboid, (1, 1, 1)), products: (1, 1, 1))", "has products of inertia, but no"},
      {"compound(part(cuboid, (1, 1, 1)), inertia: (1, 1, 1), products: (2, 0, 0))",
       "a principal moment that is not more than 0"},
      {"compound(inertia: (1, 1, 1), part(cuboid, (1, 1, 1)))", "write the parts first"},
      {"part(cuboid, (1, 1, 1))", "'type' takes"},
  };
  for (const auto& [type, wanted] : cases) {
    const auto compiled =
        CompileText(std::string("benchmark b { objects { size native; type ") + type + " } }");
    std::string refusal = dsl::Render(compiled.diagnostics);
    if (!compiled.diagnostics.has_errors()) try {
        layouts::DrawObjects(compiled.plans.at(0).runs.at(0).scene);
      } catch (const library::SceneError& error) {
        refusal = error.what();
      }
    EXPECT_NE(refusal.find(wanted), std::string::npos) << type << "\n" << refusal;
  }
}

}  // namespace
}  // namespace cdb::tests
