#include "library/meshes/overlap_volume.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "dsl/text/check.h"

namespace cdb::meshes {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Crossing {
  std::uint32_t ray;
  std::uint8_t solid;  ///< 0 or 1
  std::int8_t turns;   ///< 1 into the surface, -1 out of it
  double at;           ///< along the ray
};

/// Rays along one axis, through the middles of the cells of a grid in the plane of the other two.
class Rays {
 public:
  explicit Rays(const Eigen::AlignedBox3d& box) {
    box.sizes().maxCoeff(&along_);
    low_ = Flat(box.min());
    step_ = (Flat(box.max()) - low_) / kRays;
  }

  double CellArea() const { return step_.prod(); }

  /// All crossings with the mesh, unordered.
  void Cast(const Mesh& mesh, std::uint8_t solid, std::vector<Crossing>& crossings) const {
    std::vector<int> balance(std::size_t{kRays} * kRays, 0);
    const std::size_t begin = crossings.size();
    for (const Triangle& triangle : mesh.triangles) {
      Eigen::AlignedBox2d box;
      for (const Vector3d& corner : CornersOf(mesh, triangle)) box.extend(Flat(corner));
      const int u_end = CellFrom(box.max().x(), 0, true), v_end = CellFrom(box.max().y(), 1, true);
      for (int u = CellFrom(box.min().x(), 0, false); u < u_end; ++u)
        for (int v = CellFrom(box.min().y(), 1, false); v < v_end; ++v) {
          const auto crossing = Cross(mesh, triangle, RayAt(u, v));
          if (!crossing) continue;
          const auto ray = static_cast<std::uint32_t>(u * kRays + v);
          crossings.push_back({ray, solid, crossing->turns, crossing->at});
          balance[ray] += crossing->turns;
        }
    }
    // A ray leaves as often as it enters, unless it hit an edge so closely that rounding decided;
    // such a ray is displaced slightly until it does.
    for (std::uint32_t ray = 0; ray < balance.size(); ++ray)
      if (balance[ray] != 0) CastAside(mesh, solid, ray, begin, crossings);
  }

 private:
  Vector2d Flat(const Vector3d& p) const { return {p[(along_ + 1) % 3], p[(along_ + 2) % 3]}; }

  Vector2d RayAt(int u, int v) const {
    return low_ + step_.cwiseProduct(Vector2d(u + 0.5, v + 0.5));
  }

  /// The first cell whose ray may be beyond `coordinate`; one too many is harmless.
  int CellFrom(double coordinate, int axis, bool is_end) const {
    const double cell = (coordinate - low_[axis]) / step_[axis] - 0.5;
    return static_cast<int>(
        std::clamp(is_end ? std::floor(cell) + 2 : std::floor(cell) - 1, 0.0, double{kRays}));
  }

  /// The side of the line through two vertices on which the ray is: exactly the negative value if
  /// the vertices are exchanged; never 0.
  double Side(const Mesh& mesh, std::uint32_t from, std::uint32_t to, const Vector2d& ray) const {
    const Vector2d low = Flat(mesh.vertices[std::min(from, to)]) - ray;
    const Vector2d high = Flat(mesh.vertices[std::max(from, to)]) - ray;
    double side = low.x() * high.y() - low.y() * high.x();
    if (side == 0) side = std::numeric_limits<double>::min();
    return from < to ? side : -side;
  }

  struct Hit {
    std::int8_t turns;
    double at;
  };
  std::optional<Hit> Cross(const Mesh& mesh, const Triangle& t, const Vector2d& ray) const {
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

  void CastAside(const Mesh& mesh, std::uint8_t solid, std::uint32_t ray, std::size_t begin,
                 std::vector<Crossing>& crossings) const {
    const auto first = crossings.begin() + static_cast<std::ptrdiff_t>(begin);
    crossings.erase(
        std::remove_if(first, crossings.end(), [&](const Crossing& c) { return c.ray == ray; }),
        crossings.end());
    const Vector2d middle = RayAt(static_cast<int>(ray) / kRays, static_cast<int>(ray) % kRays);
    for (int tries = 1;; ++tries) {
      CDB_CHECK(tries < 100);  // the mesh is not closed
      const Vector2d aside =
          middle + step_.cwiseProduct(Vector2d(std::cos(tries), std::sin(tries))) / 64;
      std::vector<Crossing> found;
      int balance = 0;
      for (const Triangle& triangle : mesh.triangles)
        if (const auto hit = Cross(mesh, triangle, aside)) {
          found.push_back({ray, solid, hit->turns, hit->at});
          balance += hit->turns;
        }
      if (balance != 0) continue;
      crossings.insert(crossings.end(), found.begin(), found.end());
      return;
    }
  }

  int along_ = 0;
  Vector2d low_, step_;
};

}  // namespace

OverlapVolume OverlapVolumeOf(const Mesh& first, const Mesh& second) {
  Eigen::AlignedBox3d box;
  for (const Mesh* mesh : {&first, &second})
    for (const Vector3d& vertex : mesh->vertices) box.extend(vertex);
  const Rays rays(box);
  std::vector<Crossing> crossings;
  rays.Cast(first, 0, crossings);
  rays.Cast(second, 1, crossings);
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    return a.ray != b.ray ? a.ray < b.ray : a.at < b.at;
  });
  OverlapVolume volume;
  int winding[2] = {0, 0};
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    if (i > 0 && crossings[i].ray == crossings[i - 1].ray) {
      const double length = crossings[i].at - crossings[i - 1].at;
      if (winding[0] > 0) volume.first += length;
      if (winding[1] > 0) volume.second += length;
      if (winding[0] > 0 && winding[1] > 0) volume.common += length;
    } else {
      winding[0] = winding[1] = 0;
    }
    winding[crossings[i].solid] += crossings[i].turns;
  }
  volume.first *= rays.CellArea();
  volume.second *= rays.CellArea();
  volume.common *= rays.CellArea();
  return volume;
}

}  // namespace cdb::meshes
