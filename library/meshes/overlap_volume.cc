#include "library/meshes/overlap_volume.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "dsl/text/check.h"

namespace cdb::meshes {

using Eigen::Vector2d;
using Eigen::Vector3d;

Rays::Rays(const Eigen::AlignedBox3d& box) {
  box.sizes().maxCoeff(&along_);
  low_ = Flat(box.min());
  step_ = (Flat(box.max()) - low_) / kRays;
}

Vector3d Rays::PointAt(std::uint32_t ray, double at) const {
  const Vector2d flat = RayAt(static_cast<int>(ray) / kRays, static_cast<int>(ray) % kRays);
  Vector3d point;
  point[along_] = at;
  point[(along_ + 1) % 3] = flat.x();
  point[(along_ + 2) % 3] = flat.y();
  return point;
}

void Rays::Cast(const Mesh& mesh, std::span<const std::uint32_t> labels,
                std::vector<Crossing>& crossings) const {
  std::vector<int> balance(std::size_t{kRays} * kRays, 0);
  const std::size_t begin = crossings.size();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& triangle = mesh.triangles[i];
    Eigen::AlignedBox2d box;
    for (const Vector3d& corner : CornersOf(mesh, triangle)) box.extend(Flat(corner));
    const int u_end = CellFrom(box.max().x(), 0, true), v_end = CellFrom(box.max().y(), 1, true);
    for (int u = CellFrom(box.min().x(), 0, false); u < u_end; ++u)
      for (int v = CellFrom(box.min().y(), 1, false); v < v_end; ++v) {
        const auto hit = Cross(mesh, triangle, RayAt(u, v));
        if (!hit) continue;
        const auto ray = static_cast<std::uint32_t>(u * kRays + v);
        crossings.push_back({ray, labels[i], hit->turns, hit->at});
        balance[ray] += hit->turns;
      }
  }
  // A ray leaves as often as it enters, unless it hit an edge so closely that rounding decided;
  // such a ray is displaced slightly until it does.
  for (std::uint32_t ray = 0; ray < balance.size(); ++ray)
    if (balance[ray] != 0) CastAside(mesh, labels, ray, begin, crossings);
}

void Rays::Sort(std::vector<Crossing>& crossings) {
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    return std::tie(a.ray, a.at, a.label, a.turns) < std::tie(b.ray, b.at, b.label, b.turns);
  });
}

/// The first cell whose ray may be beyond `coordinate`; one too many is harmless.
int Rays::CellFrom(double coordinate, int axis, bool is_end) const {
  const double cell = (coordinate - low_[axis]) / step_[axis] - 0.5;
  return static_cast<int>(
      std::clamp(is_end ? std::floor(cell) + 2 : std::floor(cell) - 1, 0.0, double{kRays}));
}

/// The side of the line through two vertices on which the ray is: exactly the negative value if
/// the vertices are exchanged; never 0.
double Rays::Side(const Mesh& mesh, std::uint32_t from, std::uint32_t to,
                  const Vector2d& ray) const {
  const Vector2d low = Flat(mesh.vertices[std::min(from, to)]) - ray;
  const Vector2d high = Flat(mesh.vertices[std::max(from, to)]) - ray;
  double side = low.x() * high.y() - low.y() * high.x();
  if (side == 0) side = std::numeric_limits<double>::min();
  return from < to ? side : -side;
}

std::optional<Rays::Hit> Rays::Cross(const Mesh& mesh, const Triangle& t,
                                     const Vector2d& ray) const {
  const double opposite[3] = {Side(mesh, t[1], t[2], ray), Side(mesh, t[2], t[0], ray),
                              Side(mesh, t[0], t[1], ray)};
  const bool is_left = opposite[0] > 0;
  if (is_left != (opposite[1] > 0) || is_left != (opposite[2] > 0)) return std::nullopt;
  double sum = 0, at = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    sum += opposite[i];
    at += opposite[i] * mesh.vertices[t[i]][along_];
  }
  // Counter-clockwise as seen from the far end of the ray, which is outside.
  return Hit{static_cast<std::int8_t>(is_left ? -1 : 1), at / sum};
}

void Rays::CastAside(const Mesh& mesh, std::span<const std::uint32_t> labels, std::uint32_t ray,
                     std::size_t begin, std::vector<Crossing>& crossings) const {
  const auto first = crossings.begin() + static_cast<std::ptrdiff_t>(begin);
  crossings.erase(
      std::remove_if(first, crossings.end(), [&](const Crossing& c) { return c.ray == ray; }),
      crossings.end());
  const Vector2d middle = RayAt(static_cast<int>(ray) / kRays, static_cast<int>(ray) % kRays);
  // Displacements of a cell's 64th at most, all different.
  Vector2d turn(0.6, 0.8), by(1.0 / 64, 0);
  for (int tries = 1;; ++tries) {
    CDB_CHECK(tries < 100);  // the mesh is not closed
    by = Vector2d(turn.x() * by.x() - turn.y() * by.y(), turn.y() * by.x() + turn.x() * by.y());
    const Vector2d aside = middle + step_.cwiseProduct(by);
    std::vector<Crossing> found;
    int balance = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
      if (const auto hit = Cross(mesh, mesh.triangles[i], aside)) {
        found.push_back({ray, labels[i], hit->turns, hit->at});
        balance += hit->turns;
      }
    if (balance != 0) continue;
    crossings.insert(crossings.end(), found.begin(), found.end());
    return;
  }
}

OverlapVolume OverlapVolumeOf(const Mesh& first, const Mesh& second) {
  Eigen::AlignedBox3d box;
  for (const Mesh* mesh : {&first, &second})
    for (const Vector3d& vertex : mesh->vertices) box.extend(vertex);
  const Rays rays(box);
  std::vector<Rays::Crossing> crossings;
  rays.Cast(first, std::vector<std::uint32_t>(first.triangles.size(), 0), crossings);
  rays.Cast(second, std::vector<std::uint32_t>(second.triangles.size(), 1), crossings);
  Rays::Sort(crossings);
  OverlapVolume volume;
  int winding[2] = {0, 0};
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    if (i > 0 && crossings[i].ray == crossings[i - 1].ray) {
      const double length = crossings[i].at - crossings[i - 1].at;
      if (winding[0] > 0) volume.first += length;
      if (winding[1] > 0) volume.second += length;
      if (winding[0] > 0 && winding[1] > 0) volume.common += length;
      volume.second_in_all += winding[1] * length;
    } else {
      winding[0] = winding[1] = 0;
    }
    winding[crossings[i].label] += crossings[i].turns;
  }
  for (double* each : {&volume.first, &volume.second, &volume.common, &volume.second_in_all})
    *each *= rays.CellArea();
  return volume;
}

}  // namespace cdb::meshes
