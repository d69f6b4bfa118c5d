// Soft solids of meshes, against closed forms and against blocks.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "compiler/lints/lints.h"
#include "library/objects/solid_factory.h"
#include "runtime/protocol/verdict.h"
#include "tests/library/meshes/test_meshes.h"
#include "tests/runtime/engine/soft/soft_fixture.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

/// A file with a mesh, and scenarios that name it.
class MeshFile {
 public:
  MeshFile(const std::string& name, const meshes::Mesh& mesh)
      : path_((std::filesystem::path(testing::TempDir()) / name).lexically_normal().string()),
        bytes_(ToObj(mesh)) {
    std::ofstream(path_) << bytes_;
  }
  ~MeshFile() { std::filesystem::remove(path_); }
  MeshFile(const MeshFile&) = delete;
  MeshFile& operator=(const MeshFile&) = delete;

  const std::string& path() const { return path_; }
  /// `statements` has TYPE for the type.
  compiler::Compilation Compile(const std::string& statements, std::size_t cells,
                                const std::string& more = "") const {
    const std::string type = fmt::format("soft(\"{}\", cells: {}{})", path_, cells, more);
    std::string text =
        "benchmark b { " + statements + "; precision " + world::EnginePrecision() + " }";
    text.replace(text.find("TYPE"), 4, type);
    return CompileText(text, {{path_, bytes_}});
  }
  plan::Run Run(const std::string& statements, std::size_t cells) const {
    const compiler::Compilation result = Compile(statements, cells);
    EXPECT_FALSE(result.diagnostics.has_errors()) << dsl::Render(result.diagnostics);
    return result.plans.at(0).runs.at(0);
  }

 private:
  std::string path_, bytes_;
};

/// A bar of 0.4 m x 0.1 m x 0.1 m.
meshes::Mesh BarMesh() { return BoxMesh({0, 0, 0}, {4, 1, 1}); }

std::string Scene(const std::string& objects, double timestep, const std::string& more = "") {
  return fmt::format(
      "world {{ side 100; walls none }} soft_world springs; timestep {}; {} objects {{ quantity 1; "
      "type TYPE; margin 0.001; location at(0, 0, 0); {} }}",
      timestep, more, objects);
}

std::string Bar(const std::string& soft, double timestep, const std::string& more = "") {
  return Scene(fmt::format("size 0.4; mass {}; soft {{ {} }}", kDensity * 0.004, soft), timestep,
               more);
}

TEST(SoftMesh, BallHasNoCornersToPin) {
  const MeshFile file("ball.obj", SphereMesh(1, 4));
  const plan::Run run = file.Run(Scene("size 0.4; mass 8; soft { pin corners }", 0.0005), 6);
  try {
    MakeSoftWorld(run);
    FAIL();
  } catch (const library::SceneError& error) {
    EXPECT_THAT(error.what(), HasSubstr("soft.pin holds no nodes"));
  }
}

TEST(SoftMesh, BallFliesFreelyWithItsMomentum) {
  const MeshFile file("ball.obj", SphereMesh(1, 4));
  const plan::Run run = file.Run(
      Scene("size 0.4; mass 8; linear_velocity (0.3, 0, 0.1); angular_velocity (1, 6, 2); soft { "
            "material corotated }",
            0.0005, "cycles 300; acceleration 0;"),
      6);
  soft::SoftWorld world = MakeSoftWorld(run);
  const Vector3d first = AngularMomentumOf(world);
  // A ball of 2 m r^2 / 5, but for its coarse surface.
  EXPECT_NEAR(first.norm(), 0.4 * 8 * 0.04 * Vector3d(1, 6, 2).norm(), 0.1 * first.norm());
  for (int i = 0; i < 300; ++i) world.Step();
  EXPECT_LT((AngularMomentumOf(world) - first).norm(), 300 * 10 * kRelativeRounding * first.norm());
  const protocol::Recording recording = RecordSoft(run);
  EXPECT_LT(recording.Reals("momentum_error").back(), 300 * 10 * kRelativeRounding);
  EXPECT_EQ(recording.Ints("inverted_tetrahedra").back(), 0);
  EXPECT_NEAR(recording.Reals("volume_ratio").back(), 1, 0.02);
  EXPECT_EQ(protocol::Judge(run.scene, recording, 300).verdict, protocol::Verdict::kStable);
}

// Its velocity is that of its centre of mass, about which it spins.
TEST(SoftMesh, SpinsAboutItsCentreOfMass) {
  const MeshFile file("angle.obj", AngleMesh());
  const plan::Run run = file.Run(Scene("size 2; mass 3; linear_velocity (0.5, 0, 0); "
                                       "angular_velocity (0, 0, 3); soft { young_modulus 1e4 }",
                                       0.001, "acceleration 0;"),
                                 8);
  const soft::SoftWorld world = MakeSoftWorld(run);
  const soft::SoftMomentum momentum = soft::MomentumOf(world);
  EXPECT_NEAR(momentum.mass, 3, 1e-6);
  EXPECT_LT((momentum.sum - Vector3d(1.5, 0, 0)).norm(), 1e-5);
  // Of the angle: 5/6 from its corner, which is 1 from the middle of the box.
  EXPECT_LT((CentreOf(world) - Vector3d(-1.0 / 6, -1.0 / 6, 0)).norm(), 1e-6);
}

TEST(SoftMesh, PinsAreTheNodesNearTheOutermost) {
  const MeshFile file("ball.obj", SphereMesh(1, 4));
  const auto pinned = [&](const std::string& side) {
    const soft::SoftWorld world =
        MakeSoftWorld(file.Run(Scene("size 2; mass 1; soft { pin " + side + " }", 1e-4), 8));
    std::vector<Vector3d> places;
    const std::vector<double>& masses = world.bodies()[0].masses;
    for (std::size_t i = 0; i < masses.size(); ++i)
      if (masses[i] == 0) places.push_back(NodeAt(world, static_cast<int>(i)));
    return places;
  };
  const auto bottom = pinned("bottom");
  EXPECT_GE(bottom.size(), 4u);
  EXPECT_LE(bottom.size(), 60u);
  for (const Vector3d& place : bottom) EXPECT_LT(place.y(), -1 + 0.25 / 4 + 0.05);
  EXPECT_EQ(pinned("ends").size(), pinned("left").size() + pinned("right").size());
  EXPECT_EQ(pinned("none").size(), 0u);
}

// The limit of a long bar, as blocks: rho g L^2 / (2 E).
TEST(SoftMesh, HangingBarStretchesByItsWeight) {
  const MeshFile file("bar.obj", BarMesh());
  const double expected = kDensity * kPull * 0.16 / (2 * 1e5);
  for (const std::size_t cells : {4, 8}) {
    soft::SoftWorld world = MakeSoftWorld(
        file.Run(Bar("pin left; young_modulus 1e5; poisson_ratio 0; stiffness_damping 0.02", 0.001,
                     "acceleration (9.8, 0, 0);"),
                 cells));
    for (int i = 0; i < 1400; ++i) world.Step();
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < world.bodies()[0].masses.size(); ++i)
      if (world.bodies()[0].mesh.PlaceOf(i).x() == 1) {
        sum += NodeAt(world, static_cast<int>(i)).x() - 0.2;
        ++count;
      }
    EXPECT_NEAR(sum / count / expected, 1, 0.02) << cells;
  }
}

TEST(SoftMesh, CantileverBendsTooLittle) {
  constexpr double kModulus = 1e6, kPoisson = 0.3;
  const MeshFile file("bar.obj", BarMesh());
  const double shear = 10 * (1 + kPoisson) / (12 + 11 * kPoisson) * kModulus / (2 * (1 + kPoisson));
  const double expected = kDensity * 0.01 * kPull * std::pow(0.4, 4) / (8 * kModulus * 1e-4 / 12) +
                          kDensity * kPull * 0.16 / (2 * shear);
  std::vector<double> found;
  for (const std::size_t cells : {4, 8}) {
    soft::SoftWorld world = MakeSoftWorld(
        file.Run(Bar(fmt::format("pin left; young_modulus {}; poisson_ratio {}; stiffness_damping "
                                 "0.05",
                                 kModulus, kPoisson),
                     0.001),
                 cells));
    for (int i = 0; i < 1400; ++i) world.Step();
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < world.bodies()[0].masses.size(); ++i)
      if (world.bodies()[0].mesh.PlaceOf(i).x() == 1) {
        sum -= NodeAt(world, static_cast<int>(i)).y() -
               (world.bodies()[0].mesh.PlaceOf(i).y() - 0.5) * 0.1;
        ++count;
      }
    found.push_back(sum / count / expected);
  }
  // More than blocks with as many cells across, 0.36 and 0.66.
  EXPECT_NEAR(found[0], 0.589, 0.01);
  EXPECT_NEAR(found[1], 0.817, 0.01);
}

// The first longitudinal mode of a bar that is fixed at one end has the period 4 L sqrt(rho / E).
TEST(SoftMesh, VibratesWithThePeriodOfItsFirstMode) {
  const MeshFile file("bar.obj", BarMesh());
  constexpr double kStep = 0.00025;
  soft::SoftWorld world = MakeSoftWorld(
      file.Run(Bar("pin left; poisson_ratio 0; material corotated", kStep, "acceleration 0;"), 8));
  const soft::SoftObject& one = world.bodies()[0];
  std::vector<double> shape, start;
  for (std::size_t i = 0; i < one.masses.size(); ++i) {
    shape.push_back(std::sin(std::numbers::pi / 2 * one.mesh.PlaceOf(i).x()));
    start.push_back(NodeAt(world, static_cast<int>(i)).x());
    if (one.masses[i] > 0)
      one.body->m_nodes[static_cast<int>(i)].m_v.setX(static_cast<btScalar>(0.02 * shape[i]));
  }
  const auto amplitude = [&] {
    double sum = 0;
    for (std::size_t i = 0; i < shape.size(); ++i)
      sum += one.masses[i] * shape[i] * (NodeAt(world, static_cast<int>(i)).x() - start[i]);
    return sum;
  };
  std::vector<double> zeros;
  world.Step();
  double last = amplitude();
  for (int i = 2; i < 3000; ++i) {
    world.Step();
    const double now = amplitude();
    if ((now < 0) != (last < 0)) zeros.push_back(kStep * (i - now / (now - last)));
    last = now;
  }
  ASSERT_GE(zeros.size(), 4u);
  const double period = 2 * (zeros.back() - zeros.front()) / static_cast<double>(zeros.size() - 1);
  EXPECT_NEAR(period / (4 * 0.4 * std::sqrt(kDensity / 1e5)), 1, 0.01);
}

// The worst tetrahedron sets the time step: runs beyond the warning explode.
TEST(SoftMesh, ExplosionsAreForeseen) {
  const MeshFile file("ball.obj", SphereMesh(1, 4));
  for (const double factor : {0.9, 1.15}) {
    const auto scene = [&](double modulus) {
      return Scene(fmt::format("size 0.4; mass 8; linear_velocity (0.1, 0.03, 0.02); "
                               "angular_velocity (0.1, 0.2, 0); soft {{ pin left; young_modulus {} "
                               "}}",
                               modulus),
                   0.001, "cycles 200; acceleration 0;");
    };
    const lints::FactReaders read = {{}, MadeUpModels};
    // Without damping, it grows with the square root of the modulus.
    const auto numbers = lints::LintScene(file.Run(scene(1e9), 6).scene, read);
    ASSERT_FALSE(numbers.empty());
    const double limit = 1e9 * std::pow(2 / numbers[0].value, 2);
    const plan::Run run = file.Run(scene(limit * factor * factor), 6);
    const protocol::Judgement judgement = protocol::Judge(run.scene, RecordSoft(run), 200);
    EXPECT_EQ(judgement.verdict >= protocol::Verdict::kExploded, factor > 1)
        << factor << " " << protocol::VerdictText(judgement);
  }
}

TEST(SoftMesh, TheNumberOfNodesIsThatOfThePlan) {
  const MeshFile file("ball.obj", SphereMesh(1, 4));
  const std::string scene = Scene("size 0.4; mass 8", 0.001);
  const plan::Run run = file.Run(scene, 6);
  const std::uint64_t nodes = analysis::NodeCount(run.scene);
  EXPECT_EQ(nodes, MakeSoftWorld(run).bodies()[0].masses.size());
  EXPECT_EQ(dsl::Render(file.Compile(scene, 6, fmt::format(", nodes: {}", nodes)).diagnostics)
                .find("error"),
            std::string::npos);
  EXPECT_THAT(dsl::Render(file.Compile(scene, 6, ", nodes: 7").diagnostics),
              HasSubstr(fmt::format("its tetrahedra have {} nodes, not 7", nodes)));
}

TEST(SoftMesh, RefusesWhatIsNoSolidOrLost) {
  const MeshFile ball("ball.obj", SphereMesh(1, 4));
  meshes::Mesh open = SphereMesh(1, 2);
  open.triangles.pop_back();
  const MeshFile opened("open.obj", open);
  const auto fault = [](const MeshFile& file, std::uint64_t cells, schema::Value error) {
    analysis::ModelFault why;
    const schema::Word any{"any"}, metres{"m"};
    objects::ReadModel(
        schema::Call{"soft",
                     {schema::Text{file.path()}, any, schema::Number(cells), metres, error, any}},
        {}, why);
    return why.cause + "; " + why.remedy;
  };
  const schema::Word fit{"fit"};
  EXPECT_THAT(fault(ball, 2, fit), HasSubstr("use more cells, such as `cells: 4`"));
  EXPECT_EQ(fault(ball, 3, schema::Number(1.0)), "; ");
  EXPECT_THAT(fault(opened, 6, fit), HasSubstr("open.obj"));
  EXPECT_THAT(dsl::Render(ball.Compile("soft_world positions; world { side 9; walls none } objects "
                                       "{ quantity 1; size 1; type TYPE }",
                                       6)
                              .diagnostics),
              HasSubstr("knows no material"));
}

}  // namespace
}  // namespace cdb::tests
