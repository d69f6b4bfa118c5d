// Robots from SDF files: frames, masses and joints against compositions by hand, and what is
// refused.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <iostream>
#include <numbers>
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
using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

class Sdf : public ::testing::Test {
 protected:
  void SetUp() override {
    if (robots::HasReader(robots::Format::kSdf)) return;
    std::cout << "skipped: needs libpugixml-dev (./setup --import)\n";
    GTEST_SKIP();
  }
};

Robot SdfRobot(const std::string& model, const std::string& version = "1.9") {
  std::vector<RobotFault> faults;
  const auto robot = robots::ParseRobot(
      "<sdf version='" + version + "'><model name='m'>" + model + "</model></sdf>", "r.sdf", {},
      faults);
  EXPECT_TRUE(robot) << (faults.empty() ? "" : faults[0].cause);
  return robot.value_or(Robot());
}

Isometry3d Pose(double x, double y, double z, double roll, double pitch, double yaw) {
  return Translation3d(x, y, z) * AngleAxisd(yaw, Vector3d::UnitZ()) *
         AngleAxisd(pitch, Vector3d::UnitY()) * AngleAxisd(roll, Vector3d::UnitX());
}

TEST_F(Sdf, FramesAreComposedAsTheFileStatesThem) {
  std::vector<RobotFault> faults;
  const auto robot = robots::ReadRobot((SourceFolder() / "tests/library/robots/odd.sdf").string(),
                                       {.packages = {}, .srdf = {}, .merges = false}, faults);
  ASSERT_TRUE(robot) << faults[0].cause;
  const double degree = std::numbers::pi / 180;
  const Isometry3d base = Pose(0.3, -0.2, 0.1, 0.1, -0.2, 0.7);
  const Isometry3d mast = base * Pose(0.1, 0.2, 0.3, 10 * degree, 20 * degree, 30 * degree);
  const Isometry3d boom =
      mast * Translation3d(0, 0.2, 0.4) * Eigen::Quaterniond(0.9, 0.1, -0.2, 0.3).normalized();
  const Isometry3d rail = boom * Pose(0.2, 0.1, 0, 0.3, 0, 0.5);
  const Isometry3d slide = rail * Translation3d(0, 0, 0.1);
  const Isometry3d turn = boom * Pose(0.01, 0.02, -0.1, 0.4, -0.3, 1.2);
  const std::pair<const char*, Isometry3d> wanted[] = {
      {"boom", boom}, {"slide", slide}, {"bob", boom * Translation3d(0, 0, 1)}};
  const std::vector<Isometry3d> frames = FramesOf(*robot);
  EXPECT_EQ(robot->links[0].parts, std::vector<std::string>{"world"});
  for (const auto& [name, frame] : wanted) {
    const std::size_t index = LinkAt(*robot, name);
    ASSERT_LT(index, robot->links.size()) << name;
    EXPECT_LT((frames[index].matrix() - frame.matrix()).norm(), 1e-12) << name;
  }
  const auto joint = [&](const char* name) -> const RobotJoint& {
    return *std::ranges::find(robot->joints, name, &RobotJoint::name);
  };
  // Pivots and axes, in the frame of the model.
  const auto pivot = [&](const char* name) -> Vector3d {
    return frames[joint(name).child] * joint(name).pivot;
  };
  const auto axis = [&](const char* name) -> Vector3d {
    return frames[joint(name).child].linear() * joint(name).axis;
  };
  EXPECT_LT((pivot("turn") - turn.translation()).norm(), 1e-12);
  EXPECT_LT((axis("turn") - mast.linear() * Vector3d(1, 2, -1).normalized()).norm(), 1e-12);
  EXPECT_LT((axis("rail") - rail.linear() * Vector3d(0, 1, 1).normalized()).norm(), 1e-12);
  EXPECT_LT((pivot("swing") - boom * Vector3d(0, 0, 0.8)).norm(), 1e-12);
  EXPECT_EQ(joint("turn").limits, std::pair(-0.6, 0.9));
  EXPECT_EQ(joint("turn").effort, 4);
  EXPECT_EQ(joint("turn").velocity, 2);
  EXPECT_EQ(joint("turn").damping, 0.2);
  EXPECT_EQ(joint("turn").friction, 0.1);
  EXPECT_EQ(joint("rail").mimic, "turn");
  EXPECT_EQ(joint("rail").multiplier, 0.5);
  EXPECT_NEAR(joint("rail").offset, 0.01 - 0.5 * 0.1, 1e-15);
  // A capsule, and an ellipsoid of another density.
  const double r = 0.04, pi = std::numbers::pi;
  const double capsule = 500 * (pi * r * r * 0.5 + 4.0 / 3 * pi * r * r * r);
  const double ellipsoid = 900 * 4.0 / 3 * pi * 0.1 * 0.05 * 0.08;
  const analysis::RobotInertia& inertia = *robot->links[LinkAt(*robot, "boom")].inertia;
  EXPECT_NEAR(inertia.mass, capsule + ellipsoid, 1e-12);
  const Vector3d at = boom.inverse() * (turn * Pose(0, 0, 0.3, 0, 0.2, 0)).translation();
  EXPECT_LT((inertia.centre - capsule / (capsule + ellipsoid) * at).norm(), 1e-12);
  EXPECT_EQ(robot->links[0].inertia->mass, 3);
  EXPECT_LT((robot->links[0].inertia->centre - base * Vector3d(0.05, 0.02, -0.01)).norm(), 1e-12);
}

/// A fork that is made of a box and two tines.
TEST_F(Sdf, MassesOfMeshesAreThoseOfWhatIsWithin) {
  const std::string path = (SourceFolder() / "tests/library/robots/fork.obj").string();
  const Robot robot = SdfRobot(
      "<link name='a'><inertial auto='true'/><collision name='c'>"
      "<density>200</density><pose>1 0 0 0 0 0</pose><geometry><mesh><uri>" +
      path + "</uri><scale>2 2 2</scale></mesh></geometry></collision></link>");
  const analysis::RobotInertia& inertia = *robot.links.at(0).inertia;
  const double thick = 0.75, floor = 1.5 * 0.5 * thick, left = 0.5 * 0.75 * thick,
               right = 0.5 * 0.5 * thick;
  const double volume = floor + left + right;
  EXPECT_NEAR(inertia.mass, 200 * volume, 1e-12);
  const Vector3d centre(floor * 0.75 + left * 0.25 + right * 1.25,
                        floor * 0.25 + left * 0.875 + right * 0.75, 0.375 * volume);
  EXPECT_LT((inertia.centre - Vector3d(1, 0, 0) - centre / volume).norm(), 1e-12);
}

TEST_F(Sdf, DefaultsAreThoseOfTheFormat) {
  const Robot robot = SdfRobot("<link name='a'/>");
  EXPECT_EQ(robot.links.at(0).inertia->mass, 1);
  EXPECT_EQ(robot.links[0].inertia->tensor, Matrix3d::Identity());
  ASSERT_EQ(robot.notes.size(), 1u);
  EXPECT_NE(robot.notes[0].find("link a has no <inertial>"), std::string::npos);
  const std::string two = "<link name='a'/><link name='b'><pose>0 0 0 0 0 1</pose></link>";
  const std::string joint =
      "<joint name='j' type='revolute'><parent>a</parent><child>b</child><axis><xyz>1 0 0</xyz>";
  const Robot own = SdfRobot(two + joint + "</axis></joint>");
  EXPECT_EQ(own.joints.at(0).axis, Vector3d::UnitX());
  EXPECT_FALSE(own.joints[0].limits);
  // Before 1.5, axes are those of the model; from then on with use_parent_model_frame.
  const Vector3d turned(std::cos(1), -std::sin(1), 0);
  EXPECT_LT((SdfRobot(two + joint + "</axis></joint>", "1.4").joints.at(0).axis - turned).norm(),
            1e-15);
  EXPECT_LT((SdfRobot(two + joint +
                          "<use_parent_model_frame>1</use_parent_model_frame></axis>"
                          "</joint>",
                      "1.6")
                 .joints.at(0)
                 .axis -
             turned)
                .norm(),
            1e-15);
}

TEST_F(Sdf, AMassScalesTheInertiaOfShapes) {
  const auto inertia = [](const std::string& mass) {
    return SdfRobot(
               "<link name='a'><inertial auto='true'>" + mass +
               "</inertial><collision name='c'><geometry><box><size>1 2 3</size></box></geometry>"
               "</collision></link>")
        .links.at(0)
        .inertia.value();
  };
  EXPECT_NEAR(inertia("").mass, 6000, 1e-9);
  EXPECT_NEAR(inertia("<mass>12</mass>").mass, 12, 1e-12);
  EXPECT_NEAR(inertia("<mass>12</mass>").tensor(0, 0), 4 + 9, 1e-12);
}

TEST_F(Sdf, LinksThatNothingHoldsAreFreeAndStaticOnesFixed) {
  const std::string two = "<link name='a'/><link name='b'><pose>0 0 2 0 0 0</pose></link>";
  const Robot free = SdfRobot(two);
  ASSERT_EQ(free.links.size(), 3u);
  EXPECT_EQ(free.links[0].name, "world");
  EXPECT_EQ(free.joints[1].type, RobotJoint::Type::kFree);
  EXPECT_EQ(FramesOf(free)[2].translation(), Vector3d(0, 0, 2));
  const Robot fixed = SdfRobot("<static>true</static>" + two);
  ASSERT_EQ(fixed.links.size(), 1u);
  EXPECT_EQ(fixed.links[0].inertia->mass, 2);
  EXPECT_EQ(fixed.links[0].inertia->centre, Vector3d(0, 0, 1));
}

TEST_F(Sdf, LimitsOfOneSideAreListed) {
  const Robot robot = SdfRobot(
      "<link name='a'/><link name='b'/><joint name='j' "
      "type='prismatic'><parent>a</parent><child>b</child>"
      "<axis><limit><lower>-1</lower><upper>inf</upper></limit></axis></joint>");
  EXPECT_FALSE(robot.joints.at(0).limits);
  EXPECT_EQ(robot.left_out, std::vector<std::string>{"the only limit of joint j"});
}

TEST_F(Sdf, RefuseByNameAndLine) {
  const auto model = [](const std::string& inside) {
    return "<sdf version='1.9'>\n<model name='m'>\n<link name='a'/><link name='b'/>\n" + inside +
           "\n</model></sdf>";
  };
  const auto joint = [&](const std::string& type, const std::string& inside,
                         const std::string& child = "b") {
    return model("<joint name='j' type='" + type + "'><parent>a</parent><child>" + child +
                 "</child>" + inside + "</joint>");
  };
  const auto shape = [&](const std::string& inside) {
    return model("<link name='c'><collision><geometry>" + inside +
                 "</geometry></collision></link>");
  };
  const std::pair<std::string, const char*> cases[] = {
      {"<sdf>\n<world/></sdf>", "r.sdf:2: <world> is no model of one robot"},
      {"<sdf>\n<include/></sdf>", "r.sdf:2: <include> is no model of one robot"},
      {"<sdf/>", "r.sdf:1: there is no <model>"},
      {"<sdf><model/>\n<model/></sdf>", "r.sdf:2: there is a second <model>"},
      {"<sdf>\n<model/></sdf>", "r.sdf:2: the model has no links"},
      {model("<model name='n'/>"), "r.sdf:4: the model contains a <model>; write its links"},
      {model("<include/>"), "r.sdf:4: the model contains a <include>"},
      {model("<link name='a'/>"), "r.sdf:4: there is another link, joint or frame 'a'"},
      {model("<link name='world'/>"), "r.sdf:4: the link has the name 'world'"},
      {model("<link name='c'><pose>1 2</pose></link>"), "r.sdf:4: a pose has 2 numbers"},
      {model("<link name='c'><pose>1 2 3 x 0 0</pose></link>"),
       "a pose is 'x', which is no number"},
      {model("<link name='c'><pose>1 2 1e99 0 0 0</pose></link>"), "a pose has numbers above 1e9"},
      {model("<link name='c'><inertial><mass>-1</mass></inertial></link>"),
       "r.sdf:4: link c has the mass -1 kg"},
      {model("<link name='c'><inertial auto='true'/></link>"), "link c has no shapes to have"},
      {shape("<plane/>"), "r.sdf:4: a collision shape of link c is a <plane>"},
      {shape("<box><size>1 0 1</size></box>"), "a collision shape of link c has the sides 1 x 0"},
      {shape("<sphere/>"), "r.sdf:4: <sphere> has no <radius>"},
      {shape("<mesh><uri>x.stl</uri><submesh/></mesh>"), "link c has a submesh"},
      {joint("screw", ""), "r.sdf:4: joint j has the type 'screw'"},
      {joint("revolute", "<axis><xyz>0 0 0</xyz></axis>"), "r.sdf:4: joint j has no axis"},
      {joint("revolute", "<axis><limit><lower>1</lower><upper>0</upper></limit></axis>"),
       "r.sdf:4: joint j has the limits 1 and 0"},
      {joint("revolute", "<axis><dynamics><damping>-1</damping></dynamics></axis>"),
       "joint j has a damping or a friction below 0"},
      {joint("fixed", "", "c"), "r.sdf:4: there is no link, joint or frame 'c'"},
      {joint("fixed", "", "world"), "r.sdf:4: the child of joint j is the world"},
      {joint("fixed", "", "a"), "r.sdf:3: the joints that hold link a make a circle"},
      {model("<joint name='j' type='fixed'><parent>a</parent><child>b</child></joint>\n<joint "
             "name='k' type='fixed'><parent>world</parent><child>b</child></joint>"),
       "r.sdf:5: link b is the child of two joints, j and k"},
      {joint("revolute", "<axis><mimic joint='a'/></axis>"), "joint j mimics no joint"},
      {model("<frame name='f'><pose relative_to='g'/></frame><frame name='g'><pose "
             "relative_to='f'/></frame><link name='c'><pose relative_to='f'/></link>"
             "<joint name='j' type='fixed'><parent>a</parent><child>c</child></joint>"),
       "r.sdf:4: the pose of 'g' is relative to itself"},
      {model("<frame name='f' attached_to='g'/><frame name='g' attached_to='f'/><joint name='j' "
             "type='fixed'><parent>a</parent><child>f</child></joint>"),
       "r.sdf:4: 'f' is attached to itself"},
  };
  for (const auto& [text, wanted] : cases)
    EXPECT_NE(FaultsOf(text, "r.sdf").find(wanted), std::string::npos)
        << FaultsOf(text, "r.sdf") << "instead of " << wanted << "\n"
        << text;
  EXPECT_EQ(FaultsOf(joint("revolute", ""), "r.sdf"), "");
}

TEST(SdfWithoutReader, IsRefusedWithTheRemedy) {
  if (robots::HasReader(robots::Format::kSdf)) GTEST_SKIP();
  EXPECT_NE(FaultsOf("<sdf/>", "r.sdf").find("this build reads no SDF; install libpugixml-dev"),
            std::string::npos);
}

}  // namespace
}  // namespace cdb::tests
