// Forward kinematics against products of homogeneous matrices, and the positions of joints.
#include "library/robots/kinematic_tree.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <numbers>
#include <set>
#include <string>

#include "compiler/analysis/configurations.h"
#include "library/scene_error.h"
#include "tests/library/robots/arm_scene.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;

/// Written without the library: a rotation by Rodrigues' formula, in a matrix of four rows.
Matrix4d Turn(const Vector3d& vector) {
  Matrix4d turn = Matrix4d::Identity();
  const double angle = vector.norm();
  if (angle == 0) return turn;
  Eigen::Matrix3d cross;
  cross << 0, -vector.z(), vector.y(), vector.z(), 0, -vector.x(), -vector.y(), vector.x(), 0;
  cross /= angle;
  turn.topLeftCorner<3, 3>() += std::sin(angle) * cross + (1 - std::cos(angle)) * cross * cross;
  return turn;
}
Matrix4d Shift(const Vector3d& by) {
  Matrix4d shift = Matrix4d::Identity();
  shift.topRightCorner<3, 1>() = by;
  return shift;
}

constexpr const char* kArm =
    "benchmark b {{ configurations {{ {} }} cycles {}\n"
    "objects base {{ type cuboid; size 0.3; mass fixed; location at(1, 2, 3)\n"
    "  orientation (0.3, -0.5, 0.2) }}\n"
    "objects upper {{ type cuboid; aspect 1 : 4 : 1; size 0.1; overlap on\n"
    "  location relative_to(base, (0.1, 0.8, 0)); orientation (0, 0, 0.4) }}\n"
    "objects fore {{ type cuboid; size 0.1; overlap on; location relative_to(upper, (0, 0.7, "
    "0.2))\n"
    "  orientation (-0.2, 0.1, 0) }}\n"
    "objects hand {{ type cuboid; size 0.1; overlap on; location relative_to(fore, (0, 0.3, 0)) "
    "}}\n"
    "objects tool {{ type sphere; size 0.1; overlap on; location relative_to(hand, (0, 0, 0.2)) "
    "}}\n"
    "joints slide {{ parent fore; child hand; type slider; axis (0, 3, 4); start 0.1\n"
    "  limits {{ lower 0; upper 0.5 }} goal 0.4 }}\n"
    "joints shoulder {{ parent base; child upper; at (0.1, 0.4, 0); axis (0, 0, 2)\n"
    "  limits {{ lower -2; upper 1 }} }}\n"
    "joints elbow {{ parent upper; child fore; at (0, 0.5, 0.1); axis (1, 1, 0.5); start 0.7 }}\n"
    "joints grip {{ parent hand; child tool; type fixed }} }}\n";

plan::Scene Arm(const std::string& configurations, int cycles) {
  return SceneOfText(fmt::format(fmt::runtime(kArm), configurations, cycles));
}

void ExpectAt(const objects::Pose& pose, const Matrix4d& frame, const char* what) {
  const Vector3d place = frame.topRightCorner<3, 1>();
  const Eigen::Matrix3d turn = frame.topLeftCorner<3, 3>();
  EXPECT_LT((pose.position - place).norm(), 1e-14) << what;
  EXPECT_LT((pose.orientation.toRotationMatrix() - turn).norm(), 1e-14) << what;
}

TEST(KinematicTree, AgreesWithProductsOfMatrices) {
  const plan::Scene scene = Arm("positions uniform", 200);
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  const robots::KinematicTree tree(scene, state);
  ASSERT_EQ(tree.freedoms(), 3u);
  const std::vector<double> positions = robots::PositionsOf(scene);
  std::vector<objects::Pose> poses;
  for (std::size_t i = 0; i < 200; ++i) {
    const double slide = positions[3 * i], shoulder = positions[3 * i + 1],
                 elbow = positions[3 * i + 2];
    tree.PosesAt(std::span(positions).subspan(3 * i, 3), poses);
    const auto about = [](const Vector3d& at, const Vector3d& axis, double angle) -> Matrix4d {
      return Shift(at) * Turn(angle * axis.normalized()) * Shift(-at);
    };
    const Matrix4d base = Shift({1, 2, 3}) * Turn({0.3, -0.5, 0.2});
    const Matrix4d upper =
        base * about({0.1, 0.4, 0}, {0, 0, 2}, shoulder) * Shift({0.1, 0.8, 0}) * Turn({0, 0, 0.4});
    const Matrix4d fore = upper * about({0, 0.5, 0.1}, {1, 1, 0.5}, elbow) * Shift({0, 0.7, 0.2}) *
                          Turn({-0.2, 0.1, 0});
    const Matrix4d hand = fore * Shift(slide * Vector3d(0, 0.6, 0.8)) * Shift({0, 0.3, 0});
    const Matrix4d tool = hand * Shift({0, 0, 0.2});
    ExpectAt(poses[0], base, "base");
    ExpectAt(poses[1], upper, "upper");
    ExpectAt(poses[2], fore, "fore");
    ExpectAt(poses[3], hand, "hand");
    ExpectAt(poses[4], tool, "tool");
  }
}

TEST(KinematicTree, StartsWhereTheLayoutsPlace) {
  const plan::Scene scene = Arm("positions path", 2);
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  std::vector<objects::Pose> poses;
  robots::KinematicTree(scene, state).PosesAt(std::vector{0.1, 0.0, 0.7}, poses);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_LT((poses[i].position - state.objects[i].pose.position).norm(), 1e-14);
    EXPECT_LT(poses[i].orientation.angularDistance(state.objects[i].pose.orientation), 1e-7);
  }
}

TEST(Positions, AreDrawnWithinTheLimits) {
  const plan::Scene scene = Arm("positions uniform", 3000);
  const std::vector<double> positions = robots::PositionsOf(scene);
  ASSERT_EQ(positions.size(), 9000u);
  const std::pair<double, double> limits[] = {
      {0, 0.5}, {-2, 1}, {-std::numbers::pi, std::numbers::pi}};
  for (int joint = 0; joint < 3; ++joint) {
    double least = 1e9, most = -1e9;
    for (std::size_t i = 0; i < 3000; ++i) {
      least = std::min(least, positions[3 * i + static_cast<std::size_t>(joint)]);
      most = std::max(most, positions[3 * i + static_cast<std::size_t>(joint)]);
    }
    const auto [lower, upper] = limits[joint];
    EXPECT_GE(least, lower);
    EXPECT_LE(most, upper);
    EXPECT_LT(least - lower, 0.01 * (upper - lower));  // of 3000 draws
    EXPECT_LT(upper - most, 0.01 * (upper - lower));
  }
}

TEST(Positions, OfOtherJointsDoNotChangeThoseOfOne) {
  const std::vector<double> all = robots::PositionsOf(Arm("positions uniform", 10));
  const std::vector<double> one = robots::PositionsOf(Arm("positions uniform; of shoulder", 10));
  ASSERT_EQ(one.size(), 10u);
  for (std::size_t i = 0; i < 10; ++i) EXPECT_EQ(one[i], all[3 * i + 1]);
  EXPECT_EQ(std::set(all.begin(), all.end()).size(), all.size());
}

TEST(Positions, OfAPathGoFromStartToGoal) {
  const std::vector<double> positions = robots::PositionsOf(Arm("positions path", 4));
  const std::vector<double> slide = {0.1, 0.2, 0.3, 0.4};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(positions[3 * i], slide[i], 1e-15);
    EXPECT_EQ(positions[3 * i + 1], 0);
    EXPECT_NEAR(positions[3 * i + 2], 0.7, 1e-15);
  }
  EXPECT_EQ(positions[9], 0.4);
}

TEST(Positions, OfAListAreThoseOfItsColumns) {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "poses.csv").string();
  const std::string csv = "elbow [deg],note,slide [cm],shoulder\n90,1,10,0.5\n-180,2,25,-1\n";
  WriteFile(file, csv);
  const plan::Scene scene = SceneOfText(
      fmt::format(fmt::runtime(kArm), "positions list(\"" + file + "\")", 2), {{file, csv}});
  const std::vector<double> expected = {0.1,  0.5, std::numbers::pi / 2,
                                        0.25, -1,  -std::numbers::pi};
  const std::vector<double> positions = robots::PositionsOf(scene);
  ASSERT_EQ(positions.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(positions[i], expected[i], 1e-15) << i;
  WriteFile(file, csv + "0,3,0,0\n");
  EXPECT_THROW(robots::PositionsOf(scene), library::SceneError);
}

TEST(KinematicTree, JointsInGearFollow) {
  // elbow = 2 (-0.5 slide + 0.3) + 0.1; the limits of shoulder, -2 to 1, narrow those of slide.
  const char* const gears =
      "shoulder.gear.with slide; shoulder.gear.ratio -20; shoulder.gear.offset 3; shoulder.start "
      "1\n"
      "elbow.gear.with shoulder; elbow.gear.ratio 0.5; elbow.gear.offset 0.2";
  for (const char* positions :
       {"positions uniform", "positions path", "positions uniform; of slide"}) {
    SCOPED_TRACE(positions);
    std::string text = fmt::format(fmt::runtime(kArm), positions, 50);
    text.insert(text.rfind('}'), gears);
    text.replace(text.find("goal 0.4"), 8, "goal 0.2");
    const plan::Scene scene = SceneOfText(text);
    const std::vector<analysis::Freedom> freedoms = analysis::FreedomsOf(scene);
    ASSERT_EQ(freedoms.size(), 3u);
    EXPECT_NEAR(freedoms[0].lower, 0.1, 1e-15);
    EXPECT_NEAR(freedoms[0].upper, 0.25, 1e-15);
    const std::vector<double> all = robots::PositionsOf(scene);
    ASSERT_EQ(all.size(), 150u);
    for (std::size_t i = 0; i < all.size(); i += 3) {
      EXPECT_GE(all[i], 0.1);
      EXPECT_LE(all[i], 0.25);
      EXPECT_NEAR(all[i + 1], 3 - 20 * all[i], 1e-14);
      EXPECT_NEAR(all[i + 2], 1.7 - 10 * all[i], 1e-14);
    }
    EXPECT_NE(all[0], all[147]);
  }
}

}  // namespace
}  // namespace cdb::tests
