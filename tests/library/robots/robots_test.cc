// Robots from URDF files: frames, masses and shapes against readings that know nothing of cdb, what
// is refused, and damaged files.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <iostream>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "compiler/compile.h"
#include "library/closed_forms/scene_fault.h"
#include "library/layouts/initial_state.h"
#include "library/objects/solid_factory.h"
#include "library/robots/outline.h"
#include "library/robots/reader.h"
#include "library/scene_error.h"
#include "tests/library/robots/read_robot.h"
#include "tests/support/files.h"
#include "tests/support/folders.h"

// urdfdom keeps the links of a circle for good.
extern "C" const char* __lsan_default_suppressions() { return "leak:liburdfdom"; }

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;
using analysis::Robot;
using analysis::RobotFault;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

class Robots : public ::testing::Test {
 protected:
  void SetUp() override {
    if (robots::HasReader(robots::Format::kUrdf)) return;
    std::cout << "skipped: needs liburdfdom-dev (./setup --import)\n";
    GTEST_SKIP();
  }
};

compiler::Compilation Compiled(const std::string& text, const fs::path& folder = SourceFolder()) {
  compiler::CompileOptions options;
  options.find_fault = closed_forms::FindSceneFault;
  options.read_model = objects::ModelReader({});
  options.read_robot = robots::ReadRobot;
  const std::string path = (folder / "test.cdb").string();
  return compiler::Compile(
      path,
      [&](const std::string& file, std::string& why) -> std::optional<std::string> {
        if (file == path) return "benchmark b { cycles 1; world.side 20\n" + text + "\n}";
        return compiler::ReadFromDisk(file, why);
      },
      options);
}

std::string ErrorsOf(const std::string& text, const fs::path& folder = SourceFolder()) {
  std::string errors;
  const compiler::Compilation compiled = Compiled(text, folder);
  for (const dsl::Diagnostic& diagnostic : compiled.diagnostics.all())
    if (diagnostic.kind->severity() == dsl::Severity::kError)
      errors += diagnostic.message + "; " + diagnostic.help + "\n";
  return errors;
}

/// A link as tests/library/robots/link_frames.py prints it.
struct Reading {
  Isometry3d frame = Isometry3d::Identity();
  double mass = 0;
  Vector3d centre = Vector3d::Zero();
  Matrix3d tensor = Matrix3d::Zero();
};

std::map<std::string, Reading> ReadOtherwise(const fs::path& file, const std::string& positions) {
  const std::string command = std::string(CDB_PYTHON) + " '" +
                              (SourceFolder() / "tests/library/robots/link_frames.py").string() +
                              "' '" + file.string() + "' " + positions;
  FILE* pipe = popen(command.c_str(), "r");
  std::string text;
  std::array<char, 4096> part{};
  while (const std::size_t read = fread(part.data(), 1, part.size(), pipe))
    text.append(part.data(), read);
  EXPECT_EQ(pclose(pipe), 0) << command;
  std::map<std::string, Reading> readings;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name;
    Reading reading;
    words >> name;
    const auto take = [&](auto&& matrix) {
      for (int i = 0; i < matrix.rows(); ++i)
        for (int j = 0; j < matrix.cols(); ++j) words >> matrix(i, j);
    };
    Vector3d origin;
    Matrix3d turn;
    take(origin);
    take(turn);
    reading.frame.linear() = turn;
    reading.frame.translation() = origin;
    words >> reading.mass;
    take(reading.centre);
    take(reading.tensor);
    EXPECT_FALSE(words.fail()) << line;
    readings[name] = reading;
  }
  return readings;
}

/// (x, y, z) to (x, z, -y).
Matrix3d ZToY() { return Eigen::AngleAxisd(-std::acos(0.0), Vector3d::UnitX()).toRotationMatrix(); }

Matrix3d TensorOf(const layouts::ObjectState& object) {
  const Matrix3d turn = object.pose.orientation.toRotationMatrix();
  return turn * Vector3d(object.mass * object.solid.InertiaPerMass()).asDiagonal() *
         turn.transpose();
}

Matrix3d OfPoint(double mass, const Vector3d& way) {
  return mass * (way.squaredNorm() * Matrix3d::Identity() - way * way.transpose());
}

struct Trial {
  const char *file, *positions, *settings;
};
const Trial kTrials[] = {
    {"examples/arm.urdf", "shoulder=0.4 elbow=-0.7 wrist=0.05",
     "shoulder 0.4; elbow -0.7; wrist 0.05"},
    {"examples/cart.urdf", "left_axle=0.3 right_axle=-2", "left_axle 0.3; right_axle -2"},
    {"tests/library/robots/odd.urdf", "1st-joint=0.8 rail=0.28 rail2=0.56",
     "_1st_joint 0.8; rail 0.28"},
};

TEST_F(Robots, LinksAreWhereAnotherReadingHasThem) {
  for (const Trial& trial : kTrials) {
    const auto wanted = ReadOtherwise(SourceFolder() / trial.file, trial.positions);
    const compiler::Compilation compiled = Compiled(
        std::string("robot r { file \"") + trial.file +
        "\"; base free; density 1000; fixed_joints keep; location at(1, 2, 3); orientation (0.1, "
        "-0.2, 0.3); positions { " +
        trial.settings + " } }");
    ASSERT_FALSE(compiled.diagnostics.has_errors()) << dsl::Render(compiled.diagnostics);
    const plan::Scene& scene = compiled.plans.at(0).runs.at(0).scene;
    const layouts::InitialState state = layouts::MakeInitialState(scene);
    Isometry3d base = Isometry3d::Identity();
    base.linear() = layouts::TurnAbout({0.1, -0.2, 0.3}).toRotationMatrix();
    base.translation() = Vector3d(1, 2, 3);
    // A body of several links has the frame of the first one: the root here.
    const Isometry3d to_world = base * Isometry3d(ZToY());
    std::size_t compared = 0;
    for (std::size_t i = 0; i < state.objects.size(); ++i) {
      const layouts::ObjectState& object = state.objects[i];
      std::string name = scene.groups[i].name;
      if (name == "size_link") name = "size";
      const Reading& reading = wanted.at(name);
      const objects::Pose origin = objects::OriginOf(object.solid, object.pose);
      const bool is_root = i == 0;
      const Isometry3d frame = to_world * (is_root ? Isometry3d::Identity() : reading.frame) *
                               Isometry3d(ZToY().transpose());
      EXPECT_LT((origin.position - frame.translation()).norm(), 1e-12) << name;
      EXPECT_LT((origin.orientation.toRotationMatrix() - frame.linear()).norm(), 1e-12) << name;
      if (reading.mass == 0) continue;
      ++compared;
      EXPECT_DOUBLE_EQ(object.mass, reading.mass) << name;
      EXPECT_LT((object.pose.position - to_world * reading.centre).norm(), 1e-12) << name;
      const Matrix3d tensor = to_world.linear() * reading.tensor * to_world.linear().transpose();
      EXPECT_LT((TensorOf(object) - tensor).norm(), 1e-12 * tensor.norm())
          << name << "\n"
          << TensorOf(object) << "\n"
          << tensor;
    }
    EXPECT_GE(compared, 3u) << trial.file;
  }
}

TEST_F(Robots, FixedJointsKeepMassCentreAndInertia) {
  for (const Trial& trial : kTrials) {
    double mass = 0;
    Vector3d centre = Vector3d::Zero();
    Matrix3d tensor = Matrix3d::Zero();
    const auto readings = ReadOtherwise(SourceFolder() / trial.file, "");
    for (const auto& [name, reading] : readings) {
      mass += reading.mass;
      centre += reading.mass * reading.centre;
    }
    centre /= mass;
    for (const auto& [name, reading] : readings)
      tensor += reading.tensor + OfPoint(reading.mass, reading.centre - centre);
    for (const bool merges : {true, false}) {
      std::vector<RobotFault> faults;
      const auto robot = robots::ReadRobot((SourceFolder() / trial.file).string(),
                                           {.packages = {}, .srdf = {}, .merges = merges}, faults);
      ASSERT_TRUE(robot && faults.empty()) << trial.file;
      // All links as one, in the frame of the root.
      std::vector<Isometry3d> frames(robot->links.size(), Isometry3d::Identity());
      analysis::RobotInertia whole;
      for (std::size_t i = 0; i < robot->links.size(); ++i) {
        if (i > 0) frames[i] = frames[robot->joints[i - 1].parent] * robot->joints[i - 1].origin;
        if (robot->links[i].inertia)
          whole = robots::Together(whole, *robot->links[i].inertia, frames[i]);
      }
      EXPECT_NEAR(whole.mass, mass, 1e-12) << trial.file;
      EXPECT_LT((whole.centre - centre).norm(), 1e-12) << trial.file;
      EXPECT_LT((whole.tensor - tensor).norm(), 1e-12 * tensor.norm()) << trial.file;
    }
  }
}

TEST_F(Robots, ShapesAreThoseOfTheFile) {
  const compiler::Compilation compiled =
      Compiled("robot r { file \"tests/library/robots/odd.urdf\"; location at(0, 0, 0) }");
  ASSERT_FALSE(compiled.diagnostics.has_errors()) << dsl::Render(compiled.diagnostics);
  const plan::Scene& scene = compiled.plans.at(0).runs.at(0).scene;
  const layouts::InitialState state = layouts::MakeInitialState(scene);
  // The cylinder of the arm, by its own extents: along z of the file, and across.
  const Isometry3d in_link = Eigen::Translation3d(0, 0, 0.3) *
                             Eigen::AngleAxisd(0.2, Vector3d::UnitY()) * Isometry3d::Identity();
  const layouts::ObjectState& arm = state.objects.at(1);
  const objects::Pose origin = objects::OriginOf(arm.solid, arm.pose);
  Isometry3d frame = Isometry3d::Identity();
  frame.linear() = origin.orientation.toRotationMatrix() * ZToY();
  frame.translation() = origin.position;
  const Isometry3d cylinder = frame * in_link;
  const Vector3d half[] = {{0.04, 0, 0}, {0, 0.04, 0}, {0, 0, 0.25}};
  for (const Vector3d& way : half)
    for (const double sign : {-1.0, 1.0}) {
      const Vector3d direction = sign * cylinder.linear() * way.normalized();
      const Vector3d in_body = arm.pose.orientation.conjugate() * direction;
      const Vector3d farthest =
          arm.pose.position + arm.pose.orientation * arm.solid.Support(in_body);
      EXPECT_NEAR((farthest - cylinder.translation()).dot(direction), way.norm(), 1e-12);
    }
  EXPECT_EQ(scene.groups.at(0).settings.WordOr("mass"), "fixed") << "it hangs from the world";
  ASSERT_EQ(scene.joints.size(), 3u);
  EXPECT_EQ(scene.joints[0].name, "_1st_joint");
  EXPECT_EQ(scene.joints[0].settings.Real("joints.damping"), 0.2);
  EXPECT_EQ(scene.joints[0].settings.Real("joints.friction"), 0.1);
  EXPECT_EQ(scene.joints[1].settings.WordOr("joints.type"), "slider");
  // It starts in the middle of what the limits of both permit: 0.25 to 0.3.
  EXPECT_NEAR(scene.joints[1].settings.Real("joints.start"), 0.275, 1e-12);
  EXPECT_EQ(scene.joints[2].settings.WordOr("joints.gear.with"), "rail");
  EXPECT_EQ(scene.joints[2].settings.Real("joints.gear.ratio"), 2);
  EXPECT_NEAR(scene.joints[2].settings.Real("joints.start"), 0.55, 1e-12);
}

TEST_F(Robots, SayWhatTheyAreAndWhatIsLeftOut) {
  std::vector<RobotFault> faults;
  const auto robot =
      robots::ReadRobot((SourceFolder() / "tests/library/robots/odd.urdf").string(), {}, faults);
  ASSERT_TRUE(robot);
  const std::string summary = robots::SummaryOf(*robot, "odd.urdf");
  EXPECT_EQ(summary,
            "odd.urdf: robot odd & turned: 4 bodies, 5.1 kg; joints: 2 hinge, 1 slider; shapes: 1 "
            "box, 2 cylinder, 1 sphere\n"
            "  bodies: size, arm, slide, lens\n"
            "  hinge: 1st-joint, rail2\n"
            "  slider: rail\n"
            "  held by fixed joints, and one body: size (world), slide (camera)\n"
            "  not taken over: 2 velocity limits\n");
}

/// A robot of two links and a joint; `NAME` in `parts` replaces the default of that name.
std::string RobotText(std::map<std::string, std::string> parts) {
  const auto part = [&](const std::string& name, const char* otherwise) {
    const auto found = parts.find(name);
    return found == parts.end() ? std::string(otherwise) : found->second;
  };
  return "<robot name=\"r\">\n<link name=\"a\"/>\n<link name=\"b\">\n" +
         part("inertial",
              "<inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" "
              "iyz=\"0\" izz=\"1\"/></inertial>") +
         "\n<collision><geometry>" + part("geometry", "<box size=\"1 1 1\"/>") +
         "</geometry></collision>\n</link>\n" +
         part("joint",
              "<joint name=\"j\" type=\"continuous\"><parent link=\"a\"/><child "
              "link=\"b\"/></joint>") +
         part("more", "") + "\n</robot>\n";
}

std::string Inertial(const char* mass, const char* moments) {
  return std::string("<inertial><mass value=\"") + mass + "\"/><inertia " + moments +
         "/></inertial>";
}

TEST_F(Robots, RefuseByNameAndLine) {
  constexpr const char* kRound = "ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"";
  const auto joint = [](const char* type, const char* inside, const char* child = "b") {
    return std::string("<joint name=\"j\" type=\"") + type +
           "\"><parent link=\"a\"/><child link=\"" + child + "\"/>" + inside + "</joint>";
  };
  const auto mimic = [](const char* type, const char* inside, const char* of_other = "") {
    return RobotText(
        {{"more", std::string("<link name=\"c\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" "
                              "ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial>"
                              "</link>\n<joint name=\"k\" type=\"") +
                      type +
                      "\"><parent link=\"b\"/><child link=\"c\"/><limit lower=\"1\" "
                      "upper=\"2\" effort=\"1\" velocity=\"1\"/>" +
                      inside + "</joint>"},
         {"joint", std::string("<joint name=\"j\" type=\"revolute\"><parent link=\"a\"/><child "
                               "link=\"b\"/><limit lower=\"-0.4\" upper=\"0.4\" effort=\"1\" "
                               "velocity=\"1\"/>") +
                       of_other + "</joint>"}});
  };
  EXPECT_EQ(FaultsOf(mimic("revolute", "<mimic joint=\"j\" multiplier=\"-4\"/>"), "r.urdf"), "");
  EXPECT_EQ(
      FaultsOf(mimic("revolute", "<mimic joint=\"j\" multiplier=\"0\" offset=\"1\"/>"), "r.urdf"),
      "");
  const std::pair<std::string, const char*> cases[] = {
      {mimic("revolute", "<mimic joint=\"n\"/>"),
       "r.urdf:8: joint k mimics n, which the robot does not have"},
      {mimic("revolute", "<mimic joint=\"k\"/>"), "r.urdf:8: joint k mimics k, and so itself"},
      {mimic("revolute", "<mimic joint=\"j\"/>", "<mimic joint=\"k\"/>"),
       "r.urdf:7: joint j mimics k, and so itself in the end"},
      {mimic("revolute", "<mimic joint=\"j\" multiplier=\"2\"/>"),
       "r.urdf:8: no position of joint j keeps it and k, which mimics it, within their limits"},
      {mimic("revolute", "<mimic joint=\"j\" multiplier=\"x\"/>"), "urdfdom refuses it"},
      {RobotText({{"inertial", Inertial("-1", kRound)}}), "r.urdf:3: link b has the mass -1 kg"},
      {RobotText({{"inertial", Inertial("nan", kRound)}}), "r.urdf:3: urdfdom refuses it"},
      {RobotText({{"inertial", Inertial("1e12", kRound)}}), "r.urdf:3: link b has a mass"},
      {RobotText({{"inertial", Inertial("1",
                                        "ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" "
                                        "izz=\"3\"")}}),
       "r.urdf:3: link b has an inertia that no body has: of the principal moments 1, 1 and 3 kg "
       "m^2, one is more than the sum of the others; correct the inertia, or write `inertia any`"},
      {RobotText({{"inertial", Inertial("1",
                                        "ixx=\"1\" ixy=\"2\" ixz=\"0\" iyy=\"1\" iyz=\"0\" "
                                        "izz=\"1\"")}}),
       "one is negative"},
      {RobotText({{"inertial", Inertial("1", "ixx=\"1\"")}}), "r.urdf:3: urdfdom refuses it"},
      {RobotText({{"geometry", "<box size=\"1 0 1\"/>"}}),
       "r.urdf:3: a collision shape of link b has the sides 1 x 0 x 1"},
      {RobotText({{"geometry", "<capsule radius=\"1\" length=\"2\"/>"}}),
       "r.urdf:5: a collision shape is a <capsule>, which URDF does not have"},
      {RobotText({{"joint", joint("planar", "")}}), "r.urdf:7: joint j is planar"},
      {RobotText({{"joint", joint("continuous", "<axis xyz=\"0 0 0\"/>")}}), "joint j has no axis"},
      {RobotText(
           {{"joint",
             joint("prismatic", "<limit lower=\"1\" upper=\"-1\" effort=\"1\" velocity=\"1\"/>")}}),
       "joint j has the limits 1 and -1"},
      {RobotText({{"joint", joint("revolute", "")}}), "r.urdf:7: urdfdom refuses it"},
      {RobotText({{"joint", joint("fixed", "", "nobody")}}), "nobody"},
      {RobotText({{"more",
                   "<joint name=\"k\" type=\"fixed\"><parent link=\"a\"/><child "
                   "link=\"b\"/></joint>"}}),
       "r.urdf:7: link b is the child of two joints, j and k"},
      {RobotText({{"more",
                   "<link name=\"c\"/><link name=\"d\"/><joint name=\"k\" "
                   "type=\"fixed\"><parent link=\"c\"/><child link=\"d\"/></joint><joint "
                   "name=\"l\" type=\"fixed\"><parent link=\"d\"/><child "
                   "link=\"c\"/></joint>"}}),
       "the joints that hold link c make a circle"},
      {RobotText({{"more", "<link name=\"c\"/>"}}), "Two root links found: [a] and [c]"},
      {RobotText({{"more", "<xacro:include filename=\"x\"/>"}}), "expand it first: `xacro "},
      {"<html></html>", "r.urdf:1: begins with <html>, which is no robot"},
      {"", "r.urdf:1: has no elements"},
      {"<robot name=\"r\">\n<link name=\"a\">\n</robot>",
       "r.urdf:3: </robot> does not close <link> of line 2; write </link> before it"},
      {"<robot name=\"r\">\n<link name=\"a>\n</link></robot>", "r.urdf:2: "},
      {"<robot name=\"r\">\n<link name=\"a\"/>", "r.urdf:1: <robot> is not closed"},
      {"<!DOCTYPE r [<!ENTITY x \"y\">]><robot/>", "an entity is declared"},
      {std::string("<robot name=\"r\">\0</robot>", 26), "r.urdf: is not text in UTF-8"},
      {"<robot name=\"\xff\"/>", "r.urdf: is not text in UTF-8"},
      {std::string(robots::kMaxRobotBytes + 1, ' '), "r.urdf: has 32 MiB"},
  };
  for (const auto& [text, wanted] : cases) {
    const std::string faults = FaultsOf(text, "r.urdf");
    EXPECT_NE(faults.find(wanted), std::string::npos) << faults << "instead of " << wanted << "\n"
                                                      << text.substr(0, 1000);
  }
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "<a>";
  EXPECT_NE(FaultsOf("<robot>" + deep, "r.urdf").find("nested more than 64 deep"),
            std::string::npos);
  EXPECT_EQ(FaultsOf(RobotText({}), "r.urdf"), "");
}

/// A joint without effort has no motor; one link has the name of a word of the language.
TEST_F(Robots, NamesThatChangeAndJointsThatAreNotHeldAreStated) {
  const TemporaryFolder temporary;
  const fs::path folder = temporary.path();
  const auto joint = [](const char* name, const char* child, const char* limit) {
    return fmt::format(
        "<joint name=\"{}\" type=\"continuous\"><parent link=\"a\"/><child link=\"{}\"/>{}</joint>",
        name, child, limit);
  };
  const std::string second =
      "<link name=\"sphere\">" +
      Inertial("1", "ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"") + "</link>";
  WriteFile(folder / "none.urdf", RobotText({}));
  WriteFile(folder / "one.urdf",
            RobotText({{"more",
                        second + joint("k/1", "sphere", "<limit effort=\"5\" velocity=\"1\"/>")}}));
  const auto said = [&](const std::string& file) {
    const compiler::Compilation compiled =
        Compiled("robot r { file \"" + file + "\"; base fixed; hold on }", folder);
    std::string text = dsl::Render(compiled.diagnostics);
    for (const std::string& robot : compiled.scenario->RobotTexts()) text += robot;
    return text;
  };
  const std::string none = said("none.urdf"), one = said("one.urdf");
  EXPECT_NE(none.find("has no limit of effort for any joint, so that 'hold' gives it no motor"),
            std::string::npos)
      << none;
  EXPECT_EQ(one.find("warning"), std::string::npos) << one;
  EXPECT_NE(one.find("not held, as the file has no effort for them: j\n"), std::string::npos)
      << one;
  EXPECT_NE(one.find("link sphere is sphere_link, joint k/1 is k_1\n"), std::string::npos) << one;
}

TEST_F(Robots, AreRefusedInScenarios) {
  const TemporaryFolder temporary;
  const fs::path folder = temporary.path();
  const auto write = [&](const char* name, const std::string& text) {
    WriteFile(folder / name, text);
  };
  write("mass.urdf", RobotText({{"inertial", ""}}));
  write("mesh.urdf", RobotText({{"geometry", "<mesh filename=\"package://p/b.stl\"/>"}}));
  write("good.urdf", RobotText({}));
  write("r.srdf", "<robot><disable_collisions link1=\"a\" link2=\"c\"/></robot>");
  const std::pair<const char*, const char*> cases[] = {
      {"robot r { }", "the robot has no file"},
      {"robot r { file \"none.urdf\" }", "cannot read '"},
      {"robot r { file \"mass.urdf\"; base fixed }",
       "mass.urdf:3: link b can move, but has no mass; write <inertial> in the file, or `density "
       "1000` in the block of the robot"},
      {"robot r { file \"mass.urdf\" }",
       "mass.urdf:2: links a, b can move, but have no mass; write <inertial> in the file, or `base "
       "fixed`"},
      {"robot r { file \"mesh.urdf\" }",
       "link b has the mesh 'package://p/b.stl', but there is no file '"},
      {"robot r { file \"good.urdf\"; base up }", "'base' takes free or fixed"},
      {"robot r { file \"good.urdf\"; base fixed; srdf \"r.srdf\" }",
       "write self_collision on, or remove it"},
      {"robot r { file \"good.urdf\"; base fixed; self_collision on; srdf \"r.srdf\" }",
       "r.srdf:1: there is no link c"},
      {"robot r { file \"good.urdf\"; postions { } }", "only settings and positions { … }"},
      {"robot r { file \"good.urdf\"; frixtion 1 }", "did you mean 'friction'?"},
      {"robot r { file \"good.urdf\"; mass 1 }", "the file of a robot determines 'mass'"},
      {"robot r { file \"good.urdf\"; base fixed; positions { k 1 } }",
       "the robot has no joint 'k' that moves"},
      {"robot r { file \"good.urdf\"; base fixed }\nrobot s { file \"good.urdf\"; base fixed }",
       "there is another group 'a'; write prefix"},
      {"objects { robot r { } }", "'robot' is not allowed inside 'objects'"},
  };
  for (const auto& [text, wanted] : cases)
    EXPECT_NE(ErrorsOf(text, folder).find(wanted), std::string::npos)
        << ErrorsOf(text, folder) << "instead of " << wanted;
  EXPECT_EQ(ErrorsOf("robot r { file \"none.urdf\" }\nj.damping 3", folder).find("j.damping"),
            std::string::npos)
      << "it may be of the robot";
  EXPECT_EQ(ErrorsOf("robot r { file \"good.urdf\"; base fixed; location at(0, 0, 0) }\n"
                     "robot s { file \"good.urdf\"; base fixed; location at(5, 0, 0); prefix "
                     "\"s_\" }\nj.damping 0.5\ns_b.friction sweep(0, 1)",
                     folder),
            "");
}

TEST_F(Robots, CanBeManyAndHaveMeshesOfPackages) {
  const TemporaryFolder temporary;
  const fs::path folder = temporary.path();
  fs::create_directories(folder / "p/urdf");
  fs::create_directories(folder / "p/meshes");
  WriteFile(folder / "p/meshes/b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n");
  const std::string text =
      RobotText({{"geometry", "<mesh filename=\"package://p/meshes/b.obj\" scale=\"2 3 -4\"/>"}});
  std::string slashes = text;
  slashes.replace(slashes.find("//p"), 2, "///");
  WriteFile(folder / "p/urdf/slashes.urdf", slashes);
  EXPECT_FALSE(
      Compiled("robot r { file \"p/urdf/slashes.urdf\"; base fixed; location at(0, 0, 0) }", folder)
          .diagnostics.has_errors());
  WriteFile(folder / "p/urdf/r.urdf", text);
  const compiler::Compilation compiled = Compiled(
      "robot r { file \"p/urdf/r.urdf\"; base fixed; quantity 3; location at((0, 0, 0), (4, 0, 0), "
      "(-4, 0, 0)) }",
      folder);
  ASSERT_FALSE(compiled.diagnostics.has_errors()) << dsl::Render(compiled.diagnostics);
  const layouts::InitialState state =
      layouts::MakeInitialState(compiled.plans.at(0).runs.at(0).scene);
  ASSERT_EQ(state.objects.size(), 6u);
  const layouts::ObjectState& mesh = state.objects[4];
  const objects::Box box = objects::Bounds(mesh.solid, mesh.pose.orientation);
  // z of the file is up.
  EXPECT_LT((mesh.pose.position + box.lower - Vector3d(4, -4, -3)).norm(), 1e-12);
  EXPECT_LT((mesh.pose.position + box.upper - Vector3d(6, 0, 0)).norm(), 1e-12);
}

/// Texts of `files` with a few random edits, read: refused with a fault that names the file, or
/// sound.
void ExpectRefusedOrSound(const std::vector<const char*>& files) {
  std::vector<std::string> corpus;
  for (const char* file : files) corpus.push_back(ReadFile(SourceFolder() / file));
  std::mt19937_64 random(7);
  const auto below = [&](std::size_t count) { return count == 0 ? 0 : random() % count; };
  int read = 0, refused = 0;
  for (int i = 0; i < 4000; ++i) {
    std::string text = corpus[below(corpus.size())];
    for (std::size_t edits = 1 + below(4); edits > 0; --edits) {
      const std::string& other = corpus[below(corpus.size())];
      const std::size_t at = below(text.size() + 1);
      constexpr const char* kOdd[] = {"nan", "-1e308", "0", "\"", "<", "/>", "&#0;", "-", "inf"};
      switch (below(4)) {
        case 0:
          text.erase(at, 1 + below(24));
          break;
        case 1:
          text.insert(at, other, below(other.size() + 1), 1 + below(40));
          break;
        case 2:
          text.insert(at, 1, static_cast<char>(below(256)));
          break;
        default:
          text.replace(at, std::min(text.size() - at, below(4)), kOdd[below(std::size(kOdd))]);
      }
    }
    std::vector<RobotFault> faults;
    const auto robot = robots::ParseRobot(text, "r.urdf", {}, faults);
    ASSERT_EQ(robot.has_value(), faults.empty()) << text;
    for (const RobotFault& fault : faults)
      ASSERT_EQ(fault.cause.find("r.urdf:"), 0u) << fault.cause;
    (robot ? read : refused) += 1;
    if (!robot) continue;
    ASSERT_EQ(robot->joints.size() + 1, robot->links.size());
    for (const analysis::RobotJoint& joint : robot->joints)
      ASSERT_TRUE(joint.origin.matrix().allFinite() && joint.parent < joint.child) << text;
    for (const analysis::RobotLink& link : robot->links)
      ASSERT_TRUE(!link.inertia || (link.inertia->mass > 0 && link.inertia->tensor.allFinite()))
          << text;
  }
  EXPECT_GT(read, 100);
  EXPECT_GT(refused, 1000);
}

TEST_F(Robots, DamagedFilesAreRefusedOrSound) {
  std::vector<const char*> files;
  for (const Trial& trial : kTrials) files.push_back(trial.file);
  ExpectRefusedOrSound(files);
}

TEST(RobotsByXml, DamagedFilesAreRefusedOrSound) {
  if (!robots::HasReader(robots::Format::kSdf)) GTEST_SKIP();
  ExpectRefusedOrSound({"tests/library/robots/odd.sdf", "examples/trolley.sdf"});
  ExpectRefusedOrSound({"tests/library/robots/odd.xml", "examples/leg.xml"});
}

TEST(RobotsWithoutReader, AreRefusedWithTheRemedy) {
  if (robots::HasReader(robots::Format::kUrdf)) GTEST_SKIP();
  EXPECT_NE(ErrorsOf("robot r { file \"examples/arm.urdf\" }")
                .find("this build reads no URDF; install liburdfdom-dev"),
            std::string::npos);
}

}  // namespace
}  // namespace cdb::tests
