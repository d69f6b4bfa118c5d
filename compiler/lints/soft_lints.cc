// Lints about soft bodies.
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/analysis/soft.h"
#include "compiler/lints/lint_facts.h"
#include "compiler/schema/parametrised_words.h"

namespace cdb::lints {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Nodes about their places at the start, and the linear forces between them.
struct Vibration {
  analysis::SoftMesh mesh;
  std::vector<Vector3d> places;  ///< m
  std::vector<double> masses;    ///< of a body of 1 kg
  std::vector<char> is_pinned;

  Vibration(const plan::Group& group, analysis::SoftMesh its_mesh, const Vector3d& sides)
      : mesh(std::move(its_mesh)),
        masses(analysis::MassShares(mesh)),
        is_pinned(mesh.NodeCount(), 0) {
    for (std::size_t i = 0; i < mesh.NodeCount(); ++i)
      places.push_back(mesh.PlaceOf(i).cwiseProduct(sides));
    for (const auto& nodes :
         {analysis::PinnedNodes(group, mesh), analysis::DrivenNodes(group, mesh)})
      for (const std::uint32_t node : nodes) is_pinned[node] = 1;
  }
};

/// The highest angular frequency, rad/s, by the power iteration: a little too low. `add_forces`
/// adds minus the forces that a motion of the nodes causes.
template <typename AddForces>
double HighestFrequency(const Vibration& of, const AddForces& add_forces) {
  const std::size_t count = of.masses.size();
  std::vector<Vector3d> motion(count), force;
  for (std::size_t i = 0; i < count; ++i)  // anything that no mode is orthogonal to
    if (of.is_pinned[i]) {
      motion[i].setZero();
    } else {
      const auto place = static_cast<double>(i);
      motion[i] = {std::sin(7 * place + 1), std::sin(3 * place + 2), std::cos(5 * place)};
    }
  constexpr int kRounds = 200;
  double square = 0;
  for (int round = 0; round < kRounds; ++round) {
    force.assign(count, Vector3d::Zero());
    add_forces(motion, force);
    double largest = 0, kinetic = 0, elastic = 0;
    for (std::size_t i = 0; i < count; ++i) {
      kinetic += of.masses[i] * motion[i].squaredNorm();
      elastic += motion[i].dot(force[i]);
      motion[i] = of.is_pinned[i] ? Vector3d::Zero() : Vector3d(force[i] / of.masses[i]);
      largest = std::max(largest, motion[i].norm());
    }
    if (!(largest > 0) || !(kinetic > 0)) break;
    square = std::max(square, elastic / kinetic);
    for (Vector3d& of_node : motion) of_node /= largest;
  }
  return std::sqrt(square);
}

/// Of springs of 1 N/m in a body of 1 kg.
double HighestOfSprings(const plan::Group& group) {
  const Vector3d aspect = std::get<schema::Ratio>(group.settings.Get("aspect")).parts;
  const Vibration of(group, analysis::MeshOf(group.settings.Get("type")), aspect);
  std::vector<Vector3d> along;
  for (const auto& [a, b] : of.mesh.links)
    along.push_back((of.places[b] - of.places[a]).normalized());
  return HighestFrequency(of,
                          [&](const std::vector<Vector3d>& motion, std::vector<Vector3d>& force) {
                            for (std::size_t i = 0; i < along.size(); ++i) {
                              const auto& [a, b] = of.mesh.links[i];
                              const Vector3d pull = along[i].dot(motion[b] - motion[a]) * along[i];
                              force[a] -= pull;
                              force[b] += pull;
                            }
                          });
}

/// Of a solid of 1 kg, with a Young's modulus of 1 Pa.
double HighestOfSolid(const Vibration& of, double poisson_ratio) {
  const analysis::LameConstants lame = analysis::LameConstantsOf(1, poisson_ratio);
  std::vector<Matrix3d> inverse;
  std::vector<double> volume;
  const auto differences = [](const std::array<std::uint32_t, 4>& nodes,
                              const std::vector<Vector3d>& values) {
    return analysis::EdgesOf(nodes, [&](std::uint32_t node) { return values[node]; });
  };
  for (const auto& nodes : of.mesh.tetrahedra) {
    const Matrix3d edges = differences(nodes, of.places);
    volume.push_back(edges.determinant() / 6);
    inverse.push_back(edges.inverse());
  }
  return HighestFrequency(
      of, [&](const std::vector<Vector3d>& motion, std::vector<Vector3d>& force) {
        for (std::size_t i = 0; i < volume.size(); ++i) {
          const auto& nodes = of.mesh.tetrahedra[i];
          const Matrix3d gradient = differences(nodes, motion) * inverse[i];
          const Matrix3d stress = lame.mu * (gradient + gradient.transpose()) +
                                  lame.lambda * gradient.trace() * Matrix3d::Identity();
          const Matrix3d forces = volume[i] * stress * inverse[i].transpose();
          for (int k = 0; k < 3; ++k) {
            force[nodes[static_cast<std::size_t>(k) + 1]] += forces.col(k);
            force[nodes[0]] -= forces.col(k);
          }
        }
      });
}

/// The highest modes are of the length of a few cells, so that a part of a large block has the same
/// to 0.5 %, with an odd number of cells where the block has one: which corners of the mesh are in
/// one tetrahedron only depends on it.
double HighestOfBlock(const plan::Group& group, double size, double poisson_ratio) {
  const schema::Call& type = *schema::AsCall(group.settings.Get("type"));
  Vector3d part;
  const auto cells = [&](std::string_view argument, int axis) {
    const std::size_t all = std::get<schema::Number>(schema::ArgumentOf(type, argument)).AsCount();
    const std::size_t kept = std::min(all, 4 + all % 2);
    part[axis] = static_cast<double>(kept) / static_cast<double>(all);
    return kept;
  };
  const std::size_t columns = cells("columns", 0), layers = cells("layers", 1),
                    rows = cells("rows", 2);
  const Vector3d aspect = std::get<schema::Ratio>(group.settings.Get("aspect")).parts;
  const Vibration of(group, analysis::BlockOf(columns, rows, layers),
                     size * aspect.cwiseProduct(part));
  // The part has its part of the mass.
  return HighestOfSolid(of, poisson_ratio) / std::sqrt(part.prod());
}

/// What makes the vibrations of a group: for the mode of the angular frequency w, damped by d w,
/// w^2 = unit^2 stiffness / mass and d = damping w / stiffness.
struct Vibrating {
  double unit, stiffness, damping;
};

/// Of a solid of 1 kg, with a Young's modulus of 1 Pa; nullopt if its sides or its mesh are
/// unknown.
std::optional<double> HighestUnitOf(const plan::Group& group, double poisson_ratio,
                                    const analysis::ReadModel& read) {
  const schema::Value &type = group.settings.Get("type"), &written = group.settings.Get("size");
  const schema::Number* number = schema::AsNumber(written);
  const double size = number != nullptr ? number->AsReal() : 0;
  if (!analysis::IsOfFile(type))
    return number != nullptr ? std::optional(HighestOfBlock(group, size, poisson_ratio))
                             : std::nullopt;
  analysis::ModelFault why;
  const auto model = read ? read(type, why) : std::nullopt;
  if (!model || model->tetrahedra == nullptr) return std::nullopt;
  const Vector3d aspect = std::get<schema::Ratio>(group.settings.Get("aspect")).parts;
  return HighestOfSolid(Vibration(group, *model->tetrahedra, model->SidesOf(size, aspect)),
                        poisson_ratio);
}

std::optional<Vibrating> VibratingOf(const plan::Group& group, const analysis::ReadModel& read) {
  const auto number = [&](schema::GroupParameter parameter) {
    return schema::AsNumber(group.settings.Get(parameter))->AsReal();
  };
  const auto are_constant = [&](std::initializer_list<schema::GroupParameter> parameters) {
    return std::ranges::all_of(parameters, [&](schema::GroupParameter parameter) {
      return schema::AsNumber(group.settings.Get(parameter)) != nullptr;
    });
  };
  if (!analysis::HasSoftSolids(group)) {
    if (!are_constant({"soft.stiffness", "soft.damping"})) return std::nullopt;
    return Vibrating{HighestOfSprings(group), number("soft.stiffness"), number("soft.damping")};
  }
  if (!are_constant({"soft.young_modulus", "soft.poisson_ratio", "soft.stiffness_damping"}))
    return std::nullopt;
  const auto unit = HighestUnitOf(group, number("soft.poisson_ratio"), read);
  if (!unit) return std::nullopt;
  const double modulus = number("soft.young_modulus");
  return Vibrating{*unit, modulus, modulus * number("soft.stiffness_damping")};
}

}  // namespace

/// The springs and materials are explicit, and their damping implicit: a mode of the angular
/// frequency w explodes if w timestep exceeds 2 sqrt(1 + damping w^2 timestep / (2 stiffness)).
std::optional<LintNumber> StiffSoftSpring(const plan::Scene& scene,
                                          const analysis::ReadModel& read) {
  constexpr double kLimit = 2, kFrom = 0.9;
  if (scene.world.WordOr("soft_world") != "springs") return std::nullopt;
  const double timestep = scene.world.Real("timestep");
  std::optional<LintNumber> worst;
  for (std::size_t i = 0; i < scene.groups.size(); ++i) {
    const plan::Group& group = scene.groups[i];
    if (group.settings.Count("quantity") == 0 || !analysis::IsSoft(group.settings.Get("type")))
      continue;
    const schema::Number* mass = schema::AsNumber(group.settings.Get("mass"));
    const auto vibrating = VibratingOf(group, read);
    if (mass == nullptr || !vibrating) continue;
    const double k = vibrating->stiffness, c = vibrating->damping;
    const auto value_at = [&](double step) {
      const double square = vibrating->unit * vibrating->unit / mass->AsReal() * step;
      return std::sqrt(square * k * step / (1 + square * c / 2));
    };
    const double value = value_at(timestep);
    if (!(value >= kFrom * kLimit) || (worst && value <= worst->value)) continue;
    double step = timestep;
    while (value_at(step) >= kFrom * kLimit) step *= 0.99;
    worst = LintNumber{Lint::kStiffSpring, value, kLimit, i, step};
  }
  return worst;
}

}  // namespace cdb::lints
