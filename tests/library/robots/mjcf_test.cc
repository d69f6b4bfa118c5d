// Robots from MJCF files: frames, masses and inertias against those of MuJoCo and textbooks,
// joints, and what is refused.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <iostream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "library/robots/reader.h"
#include "tests/library/robots/read_robot.h"
#include "tests/support/folders.h"

namespace cdb::tests {
namespace {

using analysis::Robot;
using analysis::RobotFault;
using analysis::RobotJoint;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

class Mjcf : public ::testing::Test {
 protected:
  void SetUp() override {
    if (robots::HasReader(robots::Format::kMjcf)) return;
    std::cout << "skipped: needs libpugixml-dev (./setup --import)\n";
    GTEST_SKIP();
  }
};

/// What is inside of <worldbody>, and beside it.
Robot MjcfRobot(const std::string& world, const std::string& beside = "") {
  std::vector<RobotFault> faults;
  const auto robot = robots::ParseRobot(
      "<mujoco>" + beside + "<worldbody>" + world + "</worldbody></mujoco>", "r.xml", {}, faults);
  EXPECT_TRUE(robot) << (faults.empty() ? "" : faults[0].cause);
  return robot.value_or(Robot());
}

/// A file beside this one.
std::optional<Robot> ReadModel(const char* name, bool merges) {
  std::vector<RobotFault> faults;
  auto robot = robots::ReadRobot(
      (SourceFolder() / "tests/library/robots" / name).string(),
      {.packages = {}, .srdf = {}, .merges = merges, .has_dummy_links = true}, faults);
  EXPECT_TRUE(robot) << (faults.empty() ? "" : faults[0].cause);
  return robot;
}
std::optional<Robot> ReadOdd(bool merges) { return ReadModel("odd.xml", merges); }

void ExpectAsMujoco(const Robot& robot, std::istringstream& words) {
  const auto take = [&](auto&& matrix) {
    for (int i = 0; i < matrix.rows(); ++i)
      for (int j = 0; j < matrix.cols(); ++j) words >> matrix(i, j);
  };
  std::string name;
  Vector3d origin, centre, moments;
  Matrix3d axes, principal;
  double mass = 0;
  words >> name;
  take(origin);
  take(axes);
  words >> mass;
  take(centre);
  take(principal);
  take(moments);
  ASSERT_FALSE(words.fail()) << name;
  const std::size_t index = LinkAt(robot, name);
  ASSERT_LT(index, robot.links.size()) << name;
  // The base is one with the world, in the frame of the world.
  const Isometry3d seen = FramesOf(robot)[index];
  if (index > 0) {
    EXPECT_LT((seen.translation() - origin).norm(), 1e-12) << name;
    EXPECT_LT((seen.linear() - axes).norm(), 1e-12) << name;
  }
  ASSERT_TRUE(robot.links[index].inertia) << name;
  const analysis::RobotInertia& inertia = *robot.links[index].inertia;
  EXPECT_NEAR(inertia.mass, mass, 1e-12 * mass) << name;
  EXPECT_LT((seen * inertia.centre - centre).norm(), 1e-12) << name;
  const Matrix3d tensor = seen.linear() * inertia.tensor * seen.linear().transpose();
  const Matrix3d wanted = principal * moments.asDiagonal() * principal.transpose();
  // MuJoCo finds principal axes to 1e-7.
  EXPECT_LT((tensor - wanted).norm(), 1e-6 * wanted.norm()) << name << "\n" << tensor;
}

/// The number of bodies of the file of what MuJoCo says.
std::size_t ExpectBodiesOfMujoco(const char* model, const char* said) {
  const auto robot = ReadModel(model, false);
  if (!robot) return 0;
  std::ifstream file(SourceFolder() / "tests/library/robots" / said);
  std::size_t count = 0;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream words(line);
    ExpectAsMujoco(*robot, words);
    ++count;
  }
  return count;
}

TEST_F(Mjcf, BodiesAreThoseOfMujoco) {
  EXPECT_EQ(ExpectBodiesOfMujoco("odd.xml", "odd_xml.txt"), 7u);
}

TEST_F(Mjcf, MassesOfMeshesAreThoseOfMujoco) {
  EXPECT_EQ(ExpectBodiesOfMujoco("meshes.xml", "meshes_xml.txt"), 6u);
}

/// Of a body and the dummy links before it: together what the body is in MuJoCo where the joints
/// are at 0.
TEST_F(Mjcf, SeveralJointsOfABodyAreThoseOfMujoco) {
  auto robot = ReadModel("hips.xml", true);
  ASSERT_TRUE(robot);
  ASSERT_EQ(robot->joints.size(), 6u);
  const char* names[] = {"x", "z", "pitch", "yaw", "roll", "swing"};
  const double positions[] = {0.3, 1.2, -0.4, 0.5, -0.7, 0.9};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(robot->joints[i].name, names[i]);
    robot->joints[i].start = positions[i];
  }
  EXPECT_EQ(robot->joints[3].limits, std::pair(-1.0, 1.0));
  EXPECT_EQ(robot->joints[4].damping, 0.5);
  const auto frames = FramesOf(*robot);
  std::ifstream file(SourceFolder() / "tests/library/robots/hips_xml.txt");
  std::size_t bodies = 0;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream words(line);
    std::string name;
    Isometry3d frame;
    double mass = 0;
    words >> name;
    for (int i = 0; i < 3; ++i) words >> frame.translation()[i];
    for (int i = 0; i < 9; ++i) words >> frame.linear()(i / 3, i % 3);
    words >> mass;
    ASSERT_FALSE(words.fail());
    const std::size_t at = LinkAt(*robot, name);
    ASSERT_LT(at, frames.size());
    // The world is the root here, which is at rest at the origin.
    EXPECT_LT((frames[at].translation() - frame.translation()).norm(), 1e-12) << name;
    EXPECT_LT((frames[at].linear() - frame.linear()).norm(), 1e-12) << name;
    double whole = robot->links[at].inertia->mass;
    for (const char* dummy : {"_1", "_2"}) {
      const std::size_t between = LinkAt(*robot, name + dummy);
      ASSERT_LT(between, frames.size()) << name;
      EXPECT_TRUE(robot->links[between].shapes.empty());
      EXPECT_NEAR(robot->links[between].inertia->mass, 1e-3 * mass, 1e-12);
      whole += robot->links[between].inertia->mass;
    }
    EXPECT_NEAR(whole, mass, 1e-12 * mass);
    ++bodies;
  }
  EXPECT_EQ(bodies, 2u);
}

TEST_F(Mjcf, JointsAreThoseOfTheFile) {
  const auto robot = ReadOdd(true);
  ASSERT_TRUE(robot);
  const auto joint = [&](const char* name) -> const RobotJoint& {
    return *std::ranges::find(robot->joints, name, &RobotJoint::name);
  };
  using Type = RobotJoint::Type;
  const double degree = std::numbers::pi / 180;
  EXPECT_EQ(joint("turn").type, Type::kHinge);
  EXPECT_EQ(joint("turn").start, 15 * degree);
  EXPECT_EQ(joint("turn").limits, std::pair(-40 * degree, 60 * degree));
  EXPECT_EQ(joint("turn").damping, 0.1) << "the class of wood has no damping of its own";
  EXPECT_EQ(joint("turn").friction, 0.2);
  EXPECT_EQ(joint("turn").effort, 7);
  EXPECT_EQ(joint("slide").type, Type::kSlider);
  EXPECT_EQ(joint("slide").limits, std::pair(-0.1, 0.3)) << "in m";
  EXPECT_EQ(joint("slide").effort, 20) << "the smaller end of ctrlrange, times gear";
  EXPECT_EQ(joint("wheel").effort, 1);
  EXPECT_EQ(joint("wheel").mimic, "turn");
  EXPECT_EQ(joint("wheel").multiplier, 2);
  EXPECT_NEAR(joint("wheel").offset, 0.05 - 2 * 15 * degree, 1e-15) << "from where both start";
  EXPECT_EQ(joint("swing").type, Type::kBall);
  EXPECT_EQ(joint("swing").pivot, Vector3d(0, 0, 0.2));
  EXPECT_EQ(joint("cross").type, Type::kUniversal);
  EXPECT_EQ(joint("cross").axis, Vector3d::UnitX());
  EXPECT_EQ(joint("cross").axis2, Vector3d::UnitZ());
  const std::vector<std::pair<std::string, std::string>> disabled = {
      {"base", "wheel"}, {"rail", "wheel"}, {"lens", "wheel"}};
  for (const auto& pair : disabled)
    EXPECT_NE(std::ranges::find(robot->disabled, pair), robot->disabled.end()) << pair.first;
  EXPECT_EQ(std::ranges::find(robot->disabled, std::pair<std::string, std::string>("base", "bob")),
            robot->disabled.end());
}

/// As MuJoCo 3 has it, but for a hinge at -q where `ref` is q.
TEST_F(Mjcf, ArmaturesAreReadAndTakenOverOnRequest) {
  const Robot robot = MjcfRobot(
      "<body name='a'><joint name='turn' armature='0.1'/><geom size='0.1'/>"
      "<body name='b'><joint name='slide' type='slide' armature='2'/><geom size='0.1'/>"
      "<body name='c'><joint name='free' armature='0'/><geom size='0.1'/></body></body></body>");
  const auto armature_of = [&](const std::string& name) {
    const auto found = std::ranges::find(robot.joints, name, &RobotJoint::name);
    return found == robot.joints.end() ? -1 : found->armature;
  };
  EXPECT_EQ(armature_of("turn"), 0.1);
  EXPECT_EQ(armature_of("slide"), 2);
  EXPECT_EQ(armature_of("free"), 0);
  EXPECT_EQ(robot.left_out,
            std::vector<std::string>{"2 armature, unless the robot has armature on"});
}

TEST_F(Mjcf, RefIsThePositionInTheFile) {
  const Robot robot = MjcfRobot(
      "<body name='a'><geom size='1'/><body name='b' pos='0 0 2'><joint name='j' axis='1 0 0' "
      "pos='0 0.5 0' ref='90'/><geom size='1'/></body></body>");
  ASSERT_EQ(robot.joints.size(), 1u);
  const RobotJoint& joint = robot.joints[0];
  EXPECT_NEAR(joint.start, std::numbers::pi / 2, 1e-15);
  // At 0 it is turned back by a quarter about the line y = 0.5, z = 2: (0, 0, 2) comes to (0, 0.5,
  // 2.5).
  EXPECT_LT((joint.origin.translation() - Vector3d(0, 0.5, 2.5)).norm(), 1e-14);
  EXPECT_LT((FramesOf(robot)[1].translation() - Vector3d(0, 0, 2)).norm(), 1e-14);
}

TEST_F(Mjcf, MassesOfShapesAreThoseOfTextbooks) {
  const double r = 0.3, h = 0.8, density = 500, pi = std::numbers::pi;
  const auto inertia = [&](const std::string& geom) {
    const Robot robot = MjcfRobot("<body><freejoint/><geom density='500' " + geom + "/></body>");
    return robot.links.at(0).inertia.value();
  };
  const auto expect = [&](const std::string& geom, double mass, const Vector3d& moments) {
    const analysis::RobotInertia found = inertia(geom);
    EXPECT_NEAR(found.mass, mass, 1e-12 * mass) << geom;
    EXPECT_LT((found.tensor.diagonal() - moments).norm(), 1e-12 * moments.norm()) << geom;
    EXPECT_LT((found.tensor - Matrix3d(found.tensor.diagonal().asDiagonal())).norm(), 1e-14);
  };
  const double box = density * 8 * 0.1 * 0.2 * 0.3;
  expect("type='box' size='0.1 0.2 0.3'", box,
         box / 3 * Vector3d(0.04 + 0.09, 0.01 + 0.09, 0.01 + 0.04));
  const double ball = density * 4 / 3 * pi * r * r * r;
  expect("size='0.3'", ball, Vector3d::Constant(0.4 * ball * r * r));
  const double tube = density * pi * r * r * h;
  const double across = tube * (3 * r * r + h * h) / 12;
  expect("type='cylinder' size='0.3 0.4'", tube, {across, across, tube * r * r / 2});
  const double side = across + ball * (0.4 * r * r + h * h / 4 + 3.0 / 8 * h * r);
  expect("type='capsule' size='0.3 0.4'", tube + ball,
         {side, side, tube * r * r / 2 + 0.4 * ball * r * r});
  const double egg = density * 4 / 3 * pi * 0.1 * 0.2 * 0.3;
  expect("type='ellipsoid' size='0.1 0.2 0.3'", egg,
         egg / 5 * Vector3d(0.04 + 0.09, 0.01 + 0.09, 0.01 + 0.04));
  EXPECT_EQ(inertia("size='0.3' mass='7'").mass, 7);
}

TEST_F(Mjcf, SettingsOfTheCompilerApply) {
  const std::string body =
      "<body><freejoint/><inertial pos='0 0 0' mass='0.001' diaginertia='1e-6 1e-6 1e-6'/>"
      "<geom size='0.1' group='3'/><geom size='0.2'/></body>";
  EXPECT_EQ(MjcfRobot(body).links[0].inertia->mass, 0.001);
  EXPECT_EQ(MjcfRobot(body, "<compiler boundmass='0.5'/>").links[0].inertia->mass, 0.5);
  EXPECT_NEAR(MjcfRobot(body, "<compiler boundinertia='0.1'/>").links[0].inertia->tensor(1, 1), 0.1,
              1e-15);
  const double ball = 1000 * 4 / 3.0 * std::numbers::pi * 0.008;
  EXPECT_NEAR(MjcfRobot(body, "<compiler inertiafromgeom='true' inertiagrouprange='0 2'/>")
                  .links[0]
                  .inertia->mass,
              ball, 1e-12 * ball);
  const Robot turned = MjcfRobot(
      "<body><freejoint/><geom size='1'/><body name='b' euler='1 0 0'><joint range='-1 "
      "1'/><geom size='1'/></body></body>",
      "<compiler angle='radian' autolimits='false'/>");
  EXPECT_FALSE(turned.joints[0].limits);
  EXPECT_NEAR(turned.joints[0].origin(2, 1), std::sin(1.0), 1e-15);
}

TEST_F(Mjcf, TheWorldIsALinkIfItHoldsOrTouches) {
  const std::string ball = "<body name='a'><freejoint/><geom size='1'/></body>";
  EXPECT_EQ(MjcfRobot(ball + "<geom type='plane' size='1 1 1'/>").links[0].name, "a");
  EXPECT_EQ(MjcfRobot(ball + "<geom type='box' size='1 1 1'/>").links[0].name, "world");
  EXPECT_EQ(MjcfRobot(ball + "<body name='b'><freejoint/><geom size='1'/></body>").links.size(),
            3u);
  const Robot held = MjcfRobot("<body name='a'><geom size='1'/></body>");
  ASSERT_EQ(held.links.size(), 1u);
  EXPECT_EQ(held.links[0].parts, std::vector<std::string>{"world"});
}

TEST_F(Mjcf, RefuseByNameAndLine) {
  const auto body = [](const std::string& inside) {
    return "<mujoco>\n<worldbody>\n<body name='a'><freejoint/><geom size='1'/>\n" + inside +
           "\n</body></worldbody></mujoco>";
  };
  const auto in_body = [&](const std::string& inside) {
    return body("<body name='b'>" + inside + "</body>");
  };
  const std::pair<std::string, const char*> cases[] = {
      {body("<include file='x.xml'/>"), "r.xml:4: <include> stands for other elements"},
      {body("<composite type='rope'/>"), "r.xml:4: <composite> stands for other elements"},
      {in_body("<geom type='sdf'/>"), "r.xml:4: a shape has the type 'sdf'"},
      {in_body("<geom type='mesh' mesh='x'/>"), "r.xml:4: there is no mesh 'x'"},
      {in_body("<geom size='1' shellinertia='true'/>"),
       "r.xml:4: the mass of a shape is that of its"},
      {in_body("<geom type='box' size='1'/>"), "r.xml:4: size has 1 numbers; it takes 3"},
      {in_body("<geom type='box' size='1 1 x'/>"), "r.xml:4: size is 'x', which is no number"},
      {in_body("<geom size='-1'/>"), "r.xml:4: a collision shape of link b has the sides -2 x"},
      {in_body("<geom size='1' class='c'/>"), "r.xml:4: there is no class 'c'"},
      {in_body("<geom size='1' quat='0 0 0 0'/>"), "r.xml:4: quat is no orientation"},
      {in_body("<geom size='1' type='capsule' fromto='1 1 1 1 1 1'/>"),
       "r.xml:4: fromto has one point twice"},
      {in_body("<joint axis='0 0 0'/><geom size='1'/>"), "r.xml:4: joint joint_1 has no axis"},
      {in_body("<joint range='2 1'/><geom size='1'/>"),
       "r.xml:4: joint joint_1 has the limits 0.0349066 and 0.0174533"},
      {in_body("<joint type='screw'/><geom size='1'/>"), "r.xml:4: a joint has the type 'screw'"},
      {in_body("<freejoint/><geom size='1'/>"),
       "r.xml:4: body b has a free joint inside of another body"},
      {in_body("<joint/><joint/><joint/><geom size='1'/>"), "r.xml:4: body b has 3 joints; write"},
      {in_body("<joint type='slide'/><joint/><geom size='1'/>"),
       "r.xml:4: body b has 2 joints, one of the type slide"},
      {in_body("<joint/><joint/><geom size='1'/>"),
       "body b has 2 joints whose axes do not cross at right angles"},
      {in_body("<joint/><joint axis='1 0 0' damping='1'/><geom size='1'/>"),
       "body b has 2 joints, one of them with damping"},
      {body("<body name='a'><joint/><geom size='1'/></body>"), "r.xml:4: there are two links 'a'"},
      {in_body("<joint name='j'/><geom size='1'/>\n<body><joint name='j'/><geom "
               "size='1'/></body>"),
       "r.xml:5: there are two joints 'j'"},
      {in_body("<inertial mass='-1' pos='0 0 0' diaginertia='1 1 1'/>"),
       "r.xml:4: link b has the mass -1 kg"},
      {in_body("<joint/><inertial mass='1' pos='0 0 0' diaginertia='1 1 3'/>"),
       "r.xml:4: link b has an inertia that no body has"},
      {"<mujoco><worldbody/></mujoco>", "r.xml:1: there is no <body>"},
      {"<mujoco>\n<compiler coordinate='global'/></mujoco>", "r.xml:2: coordinates are global"},
      {"<mujoco>\n<compiler eulerseq='xy'/></mujoco>", "r.xml:2: eulerseq is 'xy'"},
      {"<mujoco>\n<default><default/></default></mujoco>", "r.xml:2: a class of defaults"},
      {"<mujoco>\n<asset><mesh file='x.obj' inertia='solid'/></asset></mujoco>",
       "r.xml:2: the inertia of a mesh is 'solid'; write legacy, convex, exact or shell"},
      {"<mujoco>\n<asset><mesh file='x.obj'/></asset><worldbody>\n<body><geom type='mesh' mesh='x' "
       "contype='0' conaffinity='0'/></body></worldbody></mujoco>",
       "r.xml:3: body body_1 has the mass of the mesh 'x.obj', but there is no file 'x.obj'"},
      {"<mujoco>\n<asset><mesh/></asset></mujoco>", "r.xml:2: a mesh has no file"},
      {"<mujoco>\n<body></mujoco>", "r.xml:2: </mujoco> does not close <body> of line 2"},
  };
  for (const auto& [text, wanted] : cases)
    EXPECT_NE(FaultsOf(text, "r.xml").find(wanted), std::string::npos)
        << FaultsOf(text, "r.xml") << "instead of " << wanted << "\n"
        << text;
  EXPECT_EQ(FaultsOf(in_body("<joint/><geom size='1'/>"), "r.xml"), "");
}

TEST(MjcfWithoutReader, IsRefusedWithTheRemedy) {
  if (robots::HasReader(robots::Format::kMjcf)) GTEST_SKIP();
  EXPECT_NE(FaultsOf("<mujoco/>", "r.xml").find("this build reads no MJCF; install libpugixml-dev"),
            std::string::npos);
}

}  // namespace
}  // namespace cdb::tests
