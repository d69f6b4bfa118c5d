#include "library/layouts/pose_table.h"

#include <gtest/gtest.h>

#include <numbers>

#include "compiler/plan/input_file.h"
#include "tests/library/layouts/layout_scene.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

schema::Value PathCall(const std::string& file, const std::string& sha256,
                       std::string_view then = "stay") {
  return Layout(
      "path",
      {{"file", schema::Text{file}}, {"sha256", schema::Text{sha256}}, {"then", Word(then)}});
}

layouts::Path PathOfText(const std::string& csv, std::string_view then = "stay") {
  return {*schema::AsCall(PathCall("lift.csv", "", then)), layouts::ParsePathCsv(csv, "lift.csv")};
}

std::string PathFault(const std::string& csv, std::string_view then = "stay") {
  try {
    PathOfText(csv, then);
  } catch (const library::SceneError& error) {
    return error.what();
  }
  return "";
}

TEST(Path, IsLinearBetweenItsLinesAndStaysBeforeAndAfter) {
  const layouts::Path path = PathOfText("t,x,y,z\n1,0,0,0\n3,4,0,-2\n4,4,8,-2\n");
  EXPECT_EQ(path.PositionAt(0), Vector3d(0, 0, 0));
  EXPECT_EQ(path.PositionAt(1), Vector3d(0, 0, 0));
  EXPECT_EQ(path.PositionAt(1.5), Vector3d(1, 0, -0.5));
  EXPECT_EQ(path.PositionAt(3), Vector3d(4, 0, -2));
  EXPECT_EQ(path.PositionAt(3.25), Vector3d(4, 2, -2));
  EXPECT_EQ(path.PositionAt(1e9), Vector3d(4, 8, -2));
  EXPECT_FALSE(path.has_orientation());
  EXPECT_EQ(path.OrientationAt(2).coeffs(), Quaterniond::Identity().coeffs());
}

TEST(Path, TurnsTheShorterWay) {
  const double quarter = std::numbers::pi / 2, half = std::sqrt(0.5);
  // The second line is a quarter turn about y, written as the negative of the quaternion.
  const layouts::Path path = PathOfText(
      "t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n1,0,0,0,-0.70710678118654757,0,-0.70710678118654757,"
      "0\n");
  EXPECT_TRUE(path.has_orientation());
  for (const double part : {0.0, 0.25, 0.5, 1.0}) {
    const Quaterniond turn(Eigen::AngleAxisd(part * quarter, Vector3d::UnitY()));
    EXPECT_LT(path.OrientationAt(part).angularDistance(turn), 1e-7) << part;
  }
  EXPECT_NEAR(path.OrientationAt(2).y(), -half, 1e-12);
}

TEST(Path, RepeatsFromItsFirstLine) {
  const std::string csv = "t,x,y,z\n1,0,0,0\n2,2,0,0\n5,0,0,0\n";
  const layouts::Path path = PathOfText(csv, "repeat");
  for (const double time : {1.5, 2.0, 3.5})
    for (const double later : {-4.0, 4.0, 40.0})
      EXPECT_LT((path.PositionAt(time + later) - path.PositionAt(time)).norm(), 1e-12) << time;
  EXPECT_EQ(path.PositionAt(5.5), Vector3d(1, 0, 0));
}

TEST(Path, RefusesByLineAndColumn) {
  const std::pair<const char*, const char*> rows[] = {
      {"", "lift.csv: it is empty; write a line of column names first: t,x,y,z"},
      {"t,x,y,z\n", "it has no poses; write a line for each time"},
      {"x,y,z\n0,0,0\n", "lift.csv:1: the column t is missing; a path has times"},
      {"t,x,y\n0,0,0\n", "lift.csv:1: 1 of the columns x, y, z are missing"},
      {"t,x,y,z,vx,vy,vz\n",
       "lift.csv:1: `vx`, `vy`, `vz` are not known columns; name those to read"},
      {"t,x,y,z\n0,0,0,0\n0,1,0,0\n", "lift.csv:3: t is 0, but 0 in the line before; write"},
      {"t,x,y,z\n1,0,0,0\n0.5,1,0,0\n", "lift.csv:3: t is 0.5, but 1 in the line before"},
      {"t,x,y,z\n0,0,nan,0\n", "lift.csv:2: y is `nan`"},
  };
  for (const auto& [csv, message] : rows)
    EXPECT_NE(PathFault(csv).find(message), std::string::npos) << csv << "\n" << PathFault(csv);
  EXPECT_NE(PathFault("t,x,y,z\n0,0,0,0\n", "repeat").find("a path of one pose cannot repeat"),
            std::string::npos);
  EXPECT_NE(
      PathFault("t,x,y,z\n0,0,0,0\n1,0,0,1\n", "repeat").find("its last pose differs from its"),
      std::string::npos);
  // A table of poses must not have the columns of a path.
  EXPECT_THROW(layouts::ParsePoseCsv("t,x,y,z\n0,0,0,0\n", "start.csv"), library::SceneError);
}

class KinematicObjects : public testing::Test {
 protected:
  schema::Value Write(const std::string& csv) {
    WriteFile(folder_.path() / "lift.csv", csv);
    return PathCall((folder_.path() / "lift.csv").string(), plan::Sha256Hex(csv));
  }
  TemporaryFolder folder_;
};

TEST_F(KinematicObjects, BeginWhereTheirPathIsAtTheStart) {
  plan::Scene scene = LayoutScene(1, 40, Write("t,x,y,z\n-1,0,0,0\n1,2,4,6\n"));
  EXPECT_NE(FailureOf(scene).find("write mass kinematic"), std::string::npos) << FailureOf(scene);
  SetGroup(scene, "mass", Word("kinematic"));
  SetGroup(scene, "orientation", Vector3d(0, 0, 1));
  SetGroup(scene, "angular_velocity", Vector3d(0, 0, 2));
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  const layouts::ObjectState& object = state.objects[0];
  EXPECT_TRUE(object.is_kinematic && object.IsFixed());
  EXPECT_EQ(object.pose.position, Vector3d(1, 2, 3));
  EXPECT_EQ(layouts::PoseAt(object, 0.5).position, Vector3d(1.5, 3, 4.5));
  // Without columns of orientation, it rotates by its spin.
  const Quaterniond turn(Eigen::AngleAxisd(2, Vector3d::UnitZ()));
  EXPECT_LT(layouts::PoseAt(object, 0.5).orientation.angularDistance(turn), 1e-7);
}

TEST_F(KinematicObjects, MoveByTheirVelocitiesWithoutAPath) {
  plan::Scene scene = LayoutScene(1, 40, Points({{1, 2, 3}}));
  SetGroup(scene, "mass", Word("kinematic"));
  SetGroup(scene, "linear_velocity", Vector3d(1, 0, -1));
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  EXPECT_EQ(layouts::PoseAt(state.objects[0], 8).position, Vector3d(9, 2, -5));
  EXPECT_EQ(layouts::PoseAt(state.objects[0], 8).orientation.coeffs(),
            state.objects[0].pose.orientation.coeffs());
}

}  // namespace
}  // namespace cdb::tests
