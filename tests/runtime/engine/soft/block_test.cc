// Blocks of tetrahedra, against closed forms of elasticity.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "compiler/lints/lints.h"
#include "runtime/protocol/verdict.h"
#include "tests/runtime/engine/soft/soft_fixture.h"

namespace cdb::tests {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr const char* kMaterials[] = {"linear", "corotated", "neo_hookean"};

/// `n`: cells across a bar of 0.1 m x 0.1 m, 0.4 m long.
std::string Bar(int n, bool is_upright, const std::string& soft, double timestep,
                const std::string& more = "") {
  const std::string cells = is_upright
                                ? fmt::format("columns: {0}, rows: {0}, layers: {1}", n, 4 * n)
                                : fmt::format("columns: {1}, rows: {0}, layers: {0}", n, 4 * n);
  return fmt::format(
      "world {{ side 100; walls none }} soft_world springs; timestep {}; {} objects {{ quantity 1; "
      "type block({}); size {}; aspect {}; mass {}; margin 0.001; location at(0, 0, 0); soft {{ {} "
      "}} }}",
      timestep, more, cells, is_upright ? "0.1" : "0.4",
      is_upright ? "1 : 4 : 1" : "1 : 0.25 : 0.25", kDensity * 0.004, soft);
}

/// m: the mean place of the nodes that lie at `place`, from 0 to 1, along an axis of the lattice.
Vector3d MeanAt(const soft::SoftWorld& world, int axis, double place) {
  const analysis::SoftMesh& mesh = world.bodies()[0].mesh;
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (std::size_t i = 0; i < mesh.NodeCount(); ++i) {
    if (std::abs(mesh.PlaceOf(i)[axis] - place) > 1e-9) continue;
    sum += NodeAt(world, static_cast<int>(i));
    ++count;
  }
  EXPECT_GT(count, 0);
  return sum / count;
}

TEST(Material, StressIsTheDerivativeOfTheEnergy) {
  std::mt19937 random(3);
  std::normal_distribution<> normal(0, 0.2);
  for (const soft::Law law : {soft::Law::kLinear, soft::Law::kCorotated, soft::Law::kNeoHookean}) {
    const soft::Material material{law, analysis::LameConstantsOf(2e5, 0.35), 0};
    EXPECT_NEAR(soft::StrainedBy(material, Matrix3d::Identity()).energy, 0, 1e-9);
    for (int i = 0; i < 20; ++i) {
      const Matrix3d turn(Eigen::AngleAxisd(i, Vector3d(1, 2, i).normalized()));
      const Matrix3d at =
          turn * (Matrix3d::Identity() + Matrix3d::NullaryExpr([&] { return normal(random); }));
      const Matrix3d by = Matrix3d::NullaryExpr([&] { return normal(random); });
      constexpr double kStep = 1e-5;
      const double slope = (soft::StrainedBy(material, at + kStep * by).energy -
                            soft::StrainedBy(material, at - kStep * by).energy) /
                           (2 * kStep);
      EXPECT_NEAR(soft::StrainedBy(material, at).stress.cwiseProduct(by).sum(), slope, 1);
      // A rotation strains nothing, and turns the stress.
      EXPECT_NEAR(soft::StrainedBy(material, turn).stress.norm(), 0, 1e-8);
      EXPECT_NEAR(soft::StrainedBy(material, turn * at).energy,
                  soft::StrainedBy(material, at).energy, 1e-6);
    }
  }
}

TEST(Material, SmallDeformationsObeyHookesLaw) {
  const Matrix3d strain = (Matrix3d() << 3, 1, -2, 1, -1, 0.5, -2, 0.5, 2).finished() * 1e-6;
  const auto lame = analysis::LameConstantsOf(1e6, 0.4);
  EXPECT_NEAR(lame.mu * (3 * lame.lambda + 2 * lame.mu) / (lame.lambda + lame.mu), 1e6, 1e-6);
  EXPECT_NEAR(lame.lambda / (2 * (lame.lambda + lame.mu)), 0.4, 1e-12);
  const Matrix3d hooke = 2 * lame.mu * strain + lame.lambda * strain.trace() * Matrix3d::Identity();
  for (const soft::Law law : {soft::Law::kLinear, soft::Law::kCorotated, soft::Law::kNeoHookean})
    EXPECT_LT(
        (soft::StrainedBy({law, lame, 0}, Matrix3d::Identity() + strain).stress - hooke).norm(),
        1e-4 * hooke.norm());
}

// A step without gravity gives the nodes the momentum of the stresses at its start.
TEST(Block, BulletsForcesAreThoseOfTheLaws) {
  constexpr double kStep = 1e-4;
  for (const char* material : kMaterials) {
    soft::SoftWorld world = MakeSoftWorld(
        SoftRun(Bar(1, true, std::string("material ") + material, kStep, "acceleration 0;")));
    const soft::SoftObject& one = world.bodies()[0];
    std::mt19937 random(5);
    std::uniform_real_distribution<> off(-0.01, 0.01);
    const Eigen::AngleAxisd turn(0.7, Vector3d(1, -2, 0.5).normalized());
    std::vector<Vector3d> places;
    for (int i = 0; i < one.body->m_nodes.size(); ++i) {
      btSoftBody::Node& node = one.body->m_nodes[i];
      const Vector3d place =
          turn * NodeAt(world, i) + Vector3d(off(random), off(random), off(random));
      node.m_x = node.m_q = world::ToBullet(place);
      places.push_back(NodeAt(world, i));
    }
    std::vector<Vector3d> forces(places.size(), Vector3d::Zero());
    for (std::size_t i = 0; i < one.elements.size(); ++i) {
      const auto& corners = one.mesh.tetrahedra[i];
      const soft::Element& element = one.elements[i];
      const Matrix3d gradient =
          analysis::EdgesOf(corners, [&](std::uint32_t node) { return places[node]; }) *
          element.inverse;
      const Matrix3d pull = -element.volume * soft::StrainedBy(one.material, gradient).stress *
                            element.inverse.transpose();
      for (int k = 0; k < 3; ++k) {
        forces[corners[static_cast<std::size_t>(k) + 1]] += pull.col(k);
        forces[corners[0]] -= pull.col(k);
      }
    }
    world.Step();
    double off_square = 0, square = 0;
    for (std::size_t i = 0; i < forces.size(); ++i) {
      off_square += (one.masses[i] * NodeVelocity(world, static_cast<int>(i)) / kStep - forces[i])
                        .squaredNorm();
      square += forces[i].squaredNorm();
    }
    EXPECT_GT(square, 1);
    // Bullet finds rotations to 0.01 rad (linear) and to 1e-4 (corotated).
    const double limit = std::string_view(material) == "linear"      ? 0.02
                         : std::string_view(material) == "corotated" ? 2e-4
                                                                     : 100 * kRelativeRounding;
    EXPECT_LT(std::sqrt(off_square / square), std::max(limit, 1000 * kRelativeRounding))
        << material;
  }
}

TEST(Block, HasAQuarterOfEachTetrahedronAtItsCorners) {
  const soft::SoftWorld world = MakeSoftWorld(SoftRun(Bar(2, true, "pin top", 0.001)));
  const soft::SoftObject& one = world.bodies()[0];
  std::vector<double> masses(one.masses.size(), 0.0);
  double volume = 0;
  for (std::size_t i = 0; i < one.elements.size(); ++i) {
    volume += one.elements[i].volume;
    for (const std::uint32_t node : one.mesh.tetrahedra[i])
      masses[node] += kDensity * one.elements[i].volume / 4;
  }
  EXPECT_NEAR(volume, 0.004, 1e-12);
  for (std::size_t i = 0; i < masses.size(); ++i) {
    const bool is_pinned = one.mesh.PlaceOf(i).y() == 1;
    EXPECT_NEAR(one.masses[i], is_pinned ? 0 : masses[i], 1e-12);
    EXPECT_NEAR(static_cast<double>(one.body->m_nodes[static_cast<int>(i)].m_im),
                is_pinned ? 0 : 1 / masses[i], 10 * kRelativeRounding / masses[i]);
  }
}

// A bar of length L that hangs is longer by rho g L^2 / (2 E). Without lateral contraction, its
// clamp holds nothing else, and the mesh is exact, but for finite strains, which are 0.0039 here.
TEST(Block, HangingBarStretchesByItsWeight) {
  const double expected = kDensity * kPull * 0.16 / (2 * 1e5);
  for (const char* material : {"linear", "neo_hookean"}) {
    for (const int n : {1, 2}) {
      soft::SoftWorld world =
          MakeSoftWorld(SoftRun(Bar(n, true,
                                    std::string("pin top; young_modulus 1e5; poisson_ratio 0; "
                                                "stiffness_damping 0.02; material ") +
                                        material,
                                    0.002)));
      for (int i = 0; i < 700; ++i) world.Step();
      const double stretch = -0.2 - MeanAt(world, 1, 0).y();
      EXPECT_NEAR(stretch / expected, 1, 0.02) << material << " " << n;
    }
  }
}

// With lateral contraction, the clamp stiffens its end: the closed form is the limit of a long bar,
// and coarse meshes are stiffer.
TEST(Block, HangingBarContracts) {
  constexpr double kPoisson = 0.3;
  const double expected = kDensity * kPull * 0.16 / (2 * 1e5);
  std::vector<double> errors;
  for (const int n : {1, 2}) {
    soft::SoftWorld world = MakeSoftWorld(SoftRun(Bar(
        n, true, "pin top; young_modulus 1e5; poisson_ratio 0.3; stiffness_damping 0.02", 0.0015)));
    for (int i = 0; i < 1000; ++i) world.Step();
    errors.push_back(1 - (-0.2 - MeanAt(world, 1, 0).y()) / expected);
    // Halfway, the stress is rho g L / 2.
    const double strain = kDensity * kPull * 0.2 / 1e5;
    const double wide = (NodeAt(world, (2 * n) * (n + 1) * (n + 1) + n) -
                         NodeAt(world, (2 * n) * (n + 1) * (n + 1)))
                            .norm();
    EXPECT_NEAR((wide / 0.1 - 1) / (-kPoisson * strain), 1, 0.06) << n;
    // Each part of the bar grows by (1 - 2 nu) of its strain.
    const soft::SoftVolume volume = soft::VolumeOf(world);
    EXPECT_NEAR((*volume.ratio - 1) / ((1 - 2 * kPoisson) * strain), 1, 0.25) << n;
    EXPECT_EQ(volume.inverted, 0);
  }
  EXPECT_GT(errors[0], 0.045);
  EXPECT_LT(errors[1], 0.03);
  EXPECT_GT(errors[1], 0);
}

// Near nu = 0.5, volume is kept: it grows by (1 - 2 nu) of the strain.
TEST(Block, NearlyIncompressibleBarKeepsItsVolume) {
  std::vector<double> changes, stretches;
  for (const char* poisson : {"0", "0.3", "0.49"}) {
    soft::SoftWorld world = MakeSoftWorld(SoftRun(
        Bar(2, true, std::string("pin top; stiffness_damping 0.02; poisson_ratio ") + poisson,
            0.0005)));
    for (int i = 0; i < 2000; ++i) world.Step();
    changes.push_back(*soft::VolumeOf(world).ratio - 1);
    stretches.push_back(-0.2 - MeanAt(world, 1, 0).y());
  }
  EXPECT_GT(changes[0], 0.018);
  EXPECT_LT(changes[1], 0.5 * changes[0]);
  EXPECT_LT(std::abs(changes[2]), 0.05 * changes[0]);
  for (const double stretch : stretches) EXPECT_GT(stretch, 0.8 * stretches[0]);
}

// The first longitudinal mode of a bar that is fixed at one end has the period 4 L sqrt(rho / E).
TEST(Block, VibratesAlongItselfWithThePeriodOfItsFirstMode) {
  const double expected = 4 * 0.4 * std::sqrt(kDensity / 1e5);
  std::vector<double> errors;
  for (const int n : {1, 2}) {
    constexpr double kStep = 0.0005;
    soft::SoftWorld world = MakeSoftWorld(SoftRun(
        Bar(n, true, "pin top; poisson_ratio 0; material corotated", kStep, "acceleration 0;")));
    soft::SoftObject const& one = world.bodies()[0];
    std::vector<double> shape;
    for (std::size_t i = 0; i < one.masses.size(); ++i) {
      shape.push_back(std::cos(std::numbers::pi / 2 * one.mesh.PlaceOf(i).y()));
      if (one.masses[i] > 0)
        one.body->m_nodes[static_cast<int>(i)].m_v.setY(static_cast<btScalar>(0.02 * shape[i]));
    }
    const auto amplitude = [&] {
      double sum = 0;
      for (std::size_t i = 0; i < shape.size(); ++i)
        sum += one.masses[i] * shape[i] *
               (NodeAt(world, static_cast<int>(i)).y() - (one.mesh.PlaceOf(i).y() - 0.5) * 0.4);
      return sum;
    };
    std::vector<double> zeros;
    world.Step();
    double last = amplitude();
    for (int i = 2; i < 2000; ++i) {
      world.Step();
      const double now = amplitude();
      if ((now < 0) != (last < 0)) zeros.push_back(kStep * (i - now / (now - last)));
      last = now;
    }
    ASSERT_GE(zeros.size(), 5u);
    const double period =
        2 * (zeros.back() - zeros.front()) / static_cast<double>(zeros.size() - 1);
    errors.push_back(std::abs(period / expected - 1));
  }
  EXPECT_LT(errors[0], 0.015);
  EXPECT_LT(errors[1], 0.004);
}

// Tetrahedra of constant strain lock in bending: the tip of a cantilever moves by less than
// Timoshenko's rho A g L^4 / (8 E I) + rho g L^2 / (2 k G), and the error falls with refinement.
TEST(Block, CantileverBendsTooLittle) {
  constexpr double kModulus = 1e6, kPoisson = 0.3;
  const double shear = 10 * (1 + kPoisson) / (12 + 11 * kPoisson) * kModulus / (2 * (1 + kPoisson));
  const double expected = kDensity * 0.01 * kPull * std::pow(0.4, 4) / (8 * kModulus * 1e-4 / 12) +
                          kDensity * kPull * 0.16 / (2 * shear);
  const double known[] = {0.357, 0.657, 0.797};
  for (const int n : {1, 2, 3}) {
    soft::SoftWorld world = MakeSoftWorld(SoftRun(
        Bar(n, false,
            fmt::format("pin left; young_modulus {}; poisson_ratio {}; stiffness_damping 0.05",
                        kModulus, kPoisson),
            0.002)));
    for (int i = 0; i < 700; ++i) world.Step();
    const Vector3d tip = MeanAt(world, 0, 1);
    EXPECT_NEAR(-tip.y() / expected, known[n - 1], 0.01) << n;
    EXPECT_NEAR(tip.z(), 0, n % 2 == 0 ? 1e-5 : 1e-3) << n;
  }
}

// Free flight with spin keeps momentum, angular momentum and energy. Bullet's linear material does
// not keep the last two.
TEST(Block, SpinsFreelyWithItsEnergyAndMomentum) {
  for (const char* material : {"corotated", "neo_hookean"}) {
    const plan::Run run = SoftRun(fmt::format(
        "world {{ side 100; walls none }} soft_world springs; timestep 0.0002; cycles 3000; "
        "acceleration 0; objects {{ quantity 1; type block(columns: 4, rows: 2, layers: 1); size "
        "0.4; aspect 1 : 0.25 : 0.5; mass 8; margin 0.001; location at(0, 0, 0); linear_velocity "
        "(0.3, 0, 0.1); angular_velocity (1, 6, 2); soft {{ material {} }} }}",
        material));
    soft::SoftWorld world = MakeSoftWorld(run);
    const Vector3d first = AngularMomentumOf(world);
    for (int i = 0; i < 3000; ++i) world.Step();
    const Vector3d last = AngularMomentumOf(world);
    EXPECT_LT((last - first).norm() / first.norm(), 3000 * 10 * kRelativeRounding) << material;
    const protocol::Recording recording = RecordSoft(run);
    const auto energy = recording.Reals("energy");
    const auto [low, high] = std::ranges::minmax(energy);
    EXPECT_LT(high - low, (kIsDouble ? 1e-4 : 2e-3) * energy[0]) << material;
    EXPECT_LT(recording.Reals("momentum_error").back(), 3000 * 10 * kRelativeRounding);
    EXPECT_EQ(protocol::Judge(run.scene, recording, 3000).verdict, protocol::Verdict::kStable);
  }
}

// Bullet finds the rotation of a tetrahedron to 0.01 rad only, and its stresses turn it.
TEST(Block, LinearMaterialGainsEnergyAsItSpins) {
  const plan::Run run = SoftRun(
      "world { side 100; walls none } soft_world springs; timestep 0.0002; cycles 3000; "
      "acceleration 0; objects { quantity 1; type block(columns: 4, rows: 2, layers: 1); size "
      "0.4; aspect 1 : 0.25 : 0.5; mass 8; margin 0.001; location at(0, 0, 0); "
      "angular_velocity (1, 6, 2); soft { material linear } }");
  const protocol::Judgement judgement =
      protocol::Judge(run.scene, RecordSoft(run), run.scene.world.Count("cycles"));
  EXPECT_GE(judgement.verdict, protocol::Verdict::kDrifting);
  EXPECT_EQ(judgement.criterion, "energy");
}

TEST(Block, InvertedTetrahedraArePenetrating) {
  // All but the floor of a light block is below its pinned bottom.
  const plan::Run run = SoftRun(
      "world { side 100; walls none } soft_world springs; timestep 0.001; cycles 5; acceleration "
      "0; objects { quantity 1; type block(columns: 1, rows: 1, layers: 1); size 0.1; mass 1; "
      "margin 0.001; location at(0, 0, 0); linear_velocity (0, -150, 0); soft { pin bottom; "
      "young_modulus 1; material neo_hookean } }");
  const protocol::Recording recording = RecordSoft(run);
  EXPECT_LT(recording.Reals("volume_ratio").back(), 0);
  EXPECT_EQ(recording.Ints("inverted_tetrahedra").back(), 5);
  const protocol::Judgement judgement = protocol::Judge(run.scene, recording, 5);
  EXPECT_EQ(judgement.verdict, protocol::Verdict::kPenetrating);
  EXPECT_EQ(judgement.criterion, "inverted_tetrahedra");
}

/// rad/s: of small motions about the start, the square root of the largest eigenvalue.
double HighestFrequencyOfBlock(const soft::SoftWorld& world) {
  const soft::SoftObject& one = world.bodies()[0];
  const auto n = static_cast<Eigen::Index>(one.masses.size());
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  const auto [mu, lambda] = one.material.lame;
  Eigen::Matrix<double, 6, 6> law = Eigen::Matrix<double, 6, 6>::Zero();
  law.topLeftCorner<3, 3>().setConstant(lambda);
  for (int i = 0; i < 3; ++i) {
    law(i, i) += 2 * mu;
    law(i + 3, i + 3) = mu;
  }
  for (std::size_t e = 0; e < one.elements.size(); ++e) {
    // Strains xx, yy, zz, xy, yz, zx by the displacements of the corners.
    Eigen::Matrix<double, 6, 12> strains = Eigen::Matrix<double, 6, 12>::Zero();
    for (int k = 0; k < 4; ++k) {
      const Vector3d g = k == 0 ? Vector3d(-one.elements[e].inverse.colwise().sum().transpose())
                                : Vector3d(one.elements[e].inverse.row(k - 1).transpose());
      strains.block<6, 3>(0, 3 * k) << g.x(), 0, 0, 0, g.y(), 0, 0, 0, g.z(), g.y(), g.x(), 0, 0,
          g.z(), g.y(), g.z(), 0, g.x();
    }
    const Eigen::Matrix<double, 12, 12> own =
        one.elements[e].volume * strains.transpose() * law * strains;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j)
        stiffness.block<3, 3>(3 * one.mesh.tetrahedra[e][i], 3 * one.mesh.tetrahedra[e][j]) +=
            own.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * j));
  }
  return HighestFrequency(one.masses, std::move(stiffness));
}

/// Random blocks, from a third of the limit to three times it: those beyond it explode, and only
/// those; the lint knows it before.
TEST(Block, ExplosionsAreSeenAndForeseen) {
  std::mt19937 random(11);
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<>(low, high)(random);
  };
  int exploded = 0, sound = 0;
  for (int i = 0; i < 30; ++i) {
    const auto cells = [&](int most) { return 1 + static_cast<int>(draw(0, most)); };
    const std::string type =
        fmt::format("block(columns: {}, rows: {}, layers: {})", cells(9), cells(3), cells(3));
    const double timestep = 1 / draw(60, 600), mass = std::pow(10, draw(-1, 1)),
                 aspect = std::pow(2, draw(-1, 1)), poisson = draw(0, 0.45);
    const auto run_with = [&](double modulus) {
      return SoftRun(fmt::format(
          "soft_world springs; timestep {}; cycles 200; world {{ side 100; walls none }} objects "
          "{{ quantity 1; size 1; aspect 1 : {} : 0.5; mass {}; margin 0.01; type {}; location "
          "at(0, 0, 0); linear_velocity (0.1, 0.03, 0.02); soft {{ pin {}; material {}; "
          "poisson_ratio {}; young_modulus {} }} }}",
          timestep, aspect, mass, type, i % 2 == 0 ? "left" : "bottom", kMaterials[i % 3], poisson,
          modulus));
    };
    const double unit = HighestFrequencyOfBlock(MakeSoftWorld(run_with(1)));
    const double factor = std::pow(3, draw(-1, 1));
    if (std::abs(factor - 1) < 0.1) continue;
    // A soft block that falls is no small motion: stiff ones only.
    const plan::Run run = run_with(std::pow(2 * factor / (timestep * unit), 2));
    const protocol::Recording recording = RecordSoft(run);
    const protocol::Judgement judgement = protocol::Judge(run.scene, recording, 200);
    const bool is_bad = judgement.verdict >= protocol::Verdict::kExploded;
    EXPECT_EQ(is_bad, factor > 1) << i << " " << type << " " << factor << " "
                                  << protocol::VerdictText(judgement);
    (is_bad ? exploded : sound) += 1;
    const auto numbers = lints::LintScene(run.scene);
    const bool is_foreseen =
        std::ranges::any_of(numbers, [](const lints::LintNumber& n) { return n.IsBad(); });
    EXPECT_EQ(is_foreseen, factor > 1) << i << " " << type << " " << factor;
    if (is_foreseen) {
      EXPECT_NEAR(numbers[0].value / (2 * factor), 1, 0.03) << type;
    }
  }
  EXPECT_GT(exploded, 8);
  EXPECT_GT(sound, 8);
}

// A ball that falls onto a block: the momentum of both is kept.
TEST(Block, BallAndBlockKeepTheirMomentum) {
  const plan::Run run = SoftRun(
      "world { side 100; walls none } soft_world springs; soft_cell 0.02; timestep 0.001; cycles "
      "400; acceleration 0; objects ball { quantity 1; size 0.3; mass 2; location at(0.01, 0.4, "
      "0.02); linear_velocity (0, -2, 0) } objects block { quantity 1; type block(columns: 4, "
      "rows: 4, layers: 3); size 0.5; aspect 1 : 0.6 : 1; mass 5; margin 0.01; location at(0, 0, "
      "0); soft { young_modulus 2e4 } }");
  const protocol::Recording recording = RecordSoft(run);
  EXPECT_GT(std::ranges::max(recording.Ints("contacts")), 0);
  EXPECT_LT(std::ranges::min(recording.Reals("volume_ratio")), 0.9999);
  EXPECT_LT(recording.Reals("momentum_error").back(), 400 * 100 * kRelativeRounding);
  EXPECT_EQ(recording.Ints("passed").back(), 0);
}

}  // namespace
}  // namespace cdb::tests
