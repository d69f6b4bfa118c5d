// Lints about soft bodies.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "compiler/analysis/soft.h"
#include "compiler/lints/lint_facts.h"

namespace cdb::lints {
namespace {

using Eigen::Vector2d;

/// The highest angular frequency of the springs about the start, rad/s for a stiffness of 1 N/m and
/// a mass of 1 kg, by the power iteration: a little too low.
double HighestFrequency(const plan::Group& group) {
  const analysis::SoftMesh mesh = analysis::MeshOf(group.settings.Get("type"));
  const std::vector<double> masses = analysis::MassShares(mesh);
  const double wide = std::get<schema::Ratio>(group.settings.Get("aspect")).parts.z();
  const auto place = [&](std::uint32_t node) {
    const auto [x, z] = mesh.PlaceOf(node);
    return Vector2d(x, z * wide);
  };
  std::vector<Vector2d> along;
  for (const auto& [a, b] : mesh.links) along.push_back((place(b) - place(a)).normalized());
  std::vector<char> is_pinned(masses.size(), 0);
  for (const std::uint32_t node : analysis::PinnedNodes(group)) is_pinned[node] = 1;
  std::vector<Vector2d> motion(masses.size()), force;
  for (std::size_t i = 0; i < motion.size(); ++i)  // anything that no mode is orthogonal to
    motion[i] =
        is_pinned[i] ? Vector2d::Zero() : Vector2d(std::sin(7.0 * i + 1), std::cos(5.0 * i));
  constexpr int kRounds = 200;
  double square = 0;
  for (int round = 0; round < kRounds; ++round) {
    force.assign(motion.size(), Vector2d::Zero());
    for (std::size_t i = 0; i < along.size(); ++i) {
      const auto& [a, b] = mesh.links[i];
      const Vector2d pull = along[i].dot(motion[b] - motion[a]) * along[i];
      force[a] -= pull;
      force[b] += pull;
    }
    double largest = 0, kinetic = 0, elastic = 0;
    for (std::size_t i = 0; i < motion.size(); ++i) {
      kinetic += masses[i] * motion[i].squaredNorm();
      elastic += motion[i].dot(force[i]);
      motion[i] = is_pinned[i] ? Vector2d::Zero() : Vector2d(force[i] / masses[i]);
      largest = std::max(largest, motion[i].norm());
    }
    if (!(largest > 0) || !(kinetic > 0)) break;
    square = std::max(square, elastic / kinetic);
    for (Vector2d& of_node : motion) of_node /= largest;
  }
  return std::sqrt(square);
}

}  // namespace

/// The springs are explicit, and their damping implicit: a mode of the angular frequency w explodes
/// if w timestep exceeds 2 sqrt(1 + damping w^2 timestep / (2 stiffness)).
std::optional<LintNumber> StiffSoftSpring(const plan::Scene& scene) {
  constexpr double kLimit = 2, kFrom = 0.9;
  if (scene.world.WordOr("soft_world") != "springs") return std::nullopt;
  const double timestep = scene.world.Real("timestep");
  std::optional<LintNumber> worst;
  for (std::size_t i = 0; i < scene.groups.size(); ++i) {
    const plan::Group& group = scene.groups[i];
    if (group.settings.Count("quantity") == 0 || !analysis::IsSoft(group.settings.Get("type")))
      continue;
    const schema::Number* mass = schema::AsNumber(group.settings.Get("mass"));
    const schema::Number* stiffness = schema::AsNumber(group.settings.Get("soft.stiffness"));
    const schema::Number* damping = schema::AsNumber(group.settings.Get("soft.damping"));
    if (mass == nullptr || stiffness == nullptr || damping == nullptr) continue;
    const double unit = HighestFrequency(group) / std::sqrt(mass->AsReal());
    const double k = stiffness->AsReal(), c = damping->AsReal();
    const auto value_at = [&](double step) {
      const double square = unit * unit * step;
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
