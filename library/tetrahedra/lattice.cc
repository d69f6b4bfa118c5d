#include "library/tetrahedra/lattice.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "dsl/text/check.h"

namespace cdb::tetrahedra {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// In parts of an edge: a point closer to the surface is on it.
constexpr double kOnSurface = 1e-5;
/// The same, for rounding in the test of an edge with a triangle.
constexpr double kRounding = 1e-9;
/// In half cells: how far the rays are beside the points, so that they meet no edge of the mesh
/// that is parallel to an axis.
constexpr double kAside = 1e-6;

const Point kSteps[] = {{2, 0, 0},    {0, 2, 0},   {0, 0, 2},   {1, 1, 1},  {1, 1, -1},
                        {1, -1, 1},   {1, -1, -1}, {-2, 0, 0},  {0, -2, 0}, {0, 0, -2},
                        {-1, -1, -1}, {-1, -1, 1}, {-1, 1, -1}, {-1, 1, 1}};
constexpr std::size_t kForward = 7;

/// The side of the line from `from` to `to` on which the origin is: exactly the negative value if
/// they are exchanged; never 0.
double Side(std::uint32_t a, const Vector2d& from, std::uint32_t b, const Vector2d& to) {
  const Vector2d &low = a < b ? from : to, &high = a < b ? to : from;
  double side = low.x() * high.y() - low.y() * high.x();
  if (side == 0) side = std::numeric_limits<double>::min();
  return a < b ? side : -side;
}

}  // namespace

Lattice::Lattice(const meshes::Mesh& mesh, std::size_t cells) {
  CDB_CHECK(cells >= 2 && !mesh.vertices.empty());
  Eigen::AlignedBox3d box;
  for (const Vector3d& vertex : mesh.vertices) box.extend(vertex);
  cell_ = box.sizes().maxCoeff() / static_cast<double>(cells);
  // Rounding must not add a cell.
  const Vector3d whole = ((box.sizes() / cell_).array() - 1e-6).ceil().max(1);
  size_ = 2 * (whole.cast<int>() + Point::Constant(2)) + Point::Ones();
  corner_ = box.center() - cell_ / 2 * (whole + Vector3d::Constant(2));
}

std::span<const Point> Lattice::Steps() { return kSteps; }

Crossings::Crossings(const Lattice& lattice, const meshes::Mesh& mesh)
    : lattice_(lattice), sign_(lattice.IndexCount(), -1) {
  // If a ray leaves the mesh less often than it enters, rounding at an edge decided: then all of
  // them are displaced in another direction.
  for (int tries = 1; !FindInside(mesh, tries); ++tries) CDB_CHECK(tries < 32);
  FindCuts(mesh);
}

bool Crossings::FindInside(const meshes::Mesh& mesh, double aside) {
  struct Hit {
    std::size_t row;
    double at;
    int turns;
    auto Order() const { return std::tuple(row, at, turns); }
  };
  std::vector<Hit> hits;
  const Vector2d off = kAside * Vector2d(std::cos(aside), std::sin(aside));  // of y and z
  for (const meshes::Triangle& t : mesh.triangles) {
    std::array<Vector3d, 3> at;
    for (std::size_t i = 0; i < 3; ++i) at[i] = lattice_.CoordinatesOf(mesh.vertices[t[i]]);
    const auto range = [&](int axis, double displaced) {
      const auto [low, high] = std::minmax({at[0][axis], at[1][axis], at[2][axis]});
      return std::pair(
          std::max(0, static_cast<int>(std::floor(low - displaced))),
          std::min(lattice_.size()[axis] - 1, static_cast<int>(std::ceil(high - displaced))));
    };
    const auto [y_low, y_high] = range(1, off.x());
    const auto [z_low, z_high] = range(2, off.y());
    for (int y = y_low; y <= y_high; ++y)
      for (int z = z_low + (z_low + y) % 2; z <= z_high; z += 2) {
        const Vector2d ray = Vector2d(y, z) + off;
        std::array<Vector2d, 3> flat;
        for (std::size_t i = 0; i < 3; ++i) flat[i] = at[i].tail<2>() - ray;
        const double opposite[3] = {Side(t[1], flat[1], t[2], flat[2]),
                                    Side(t[2], flat[2], t[0], flat[0]),
                                    Side(t[0], flat[0], t[1], flat[1])};
        const bool is_left = opposite[0] > 0;
        if (is_left != (opposite[1] > 0) || is_left != (opposite[2] > 0)) continue;
        double sum = 0, along = 0;
        for (std::size_t i = 0; i < 3; ++i) {
          sum += opposite[i];
          along += opposite[i] * at[i].x();
        }
        // Counter-clockwise as seen from the far end of the ray, which is outside.
        hits.push_back({lattice_.IndexOf({0, y, z}), along / sum, is_left ? -1 : 1});
      }
  }
  std::ranges::sort(hits, {}, &Hit::Order);
  for (std::size_t begin = 0, end; begin < hits.size(); begin = end) {
    int winding = 0;
    for (end = begin; end < hits.size() && hits[end].row == hits[begin].row; ++end) {
      winding += hits[end].turns;
      if (winding <= 0 || end + 1 == hits.size() || hits[end + 1].row != hits[end].row) continue;
      const int parity =
          static_cast<int>(hits[end].row / static_cast<std::size_t>(lattice_.size().x())) %
          lattice_.size().z() % 2;
      for (int x = std::max(0, static_cast<int>(std::ceil(hits[end].at)));
           x < lattice_.size().x() && x <= hits[end + 1].at; ++x)
        if (x % 2 == parity) sign_[hits[end].row + static_cast<std::size_t>(x)] = 1;
    }
    if (winding == 0) continue;
    std::ranges::fill(sign_, std::int8_t{-1});
    return false;
  }
  return true;
}

void Crossings::FindCuts(const meshes::Mesh& mesh) {
  for (const meshes::Triangle& t : mesh.triangles) {
    std::array<Vector3d, 3> at;
    for (std::size_t i = 0; i < 3; ++i) at[i] = lattice_.CoordinatesOf(mesh.vertices[t[i]]);
    CutBy(at);
  }
}

void Crossings::CutBy(const std::array<Vector3d, 3>& at) {
  const Vector3d normal = (at[1] - at[0]).cross(at[2] - at[0]);
  const double square = normal.squaredNorm();
  if (!(square > 0)) return;
  const Vector3d low = at[0].cwiseMin(at[1]).cwiseMin(at[2]).array() - kRounding,
                 high = at[0].cwiseMax(at[1]).cwiseMax(at[2]).array() + kRounding;
  for (std::size_t step = 0; step < kForward; ++step) {
    const Point& by = kSteps[step];
    const Vector3d along = by.cast<double>();
    const double speed = normal.dot(along);
    if (speed * speed <= 1e-24 * square) continue;  // parallel: other edges cross it
    const Point first = (low - along.cwiseMax(0)).array().ceil().max(0).cast<int>();
    const Point last =
        (high - along.cwiseMin(0)).array().floor().cast<int>().min(lattice_.size().array() - 1);
    for (int y = first.y(); y <= last.y(); ++y)
      for (int z = first.z() + (first.z() + y) % 2; z <= last.z(); z += 2)
        for (int x = first.x() + (first.x() + y) % 2; x <= last.x(); x += 2) {
          const Point start(x, y, z);
          if (!lattice_.Has(start + by)) continue;
          const Vector3d from = start.cast<double>();
          const double part = normal.dot(at[0] - from) / speed;
          if (!(part >= -kRounding && part <= 1 + kRounding)) continue;
          const Vector3d point = from + part * along;
          bool is_in = true;
          for (std::size_t i = 0; i < 3 && is_in; ++i) {
            const Vector3d &a = at[i], &b = at[(i + 1) % 3];
            is_in = (b - a).cross(point - a).dot(normal) >= -kRounding * square;
          }
          if (!is_in) continue;
          if (part < kOnSurface) PutOnSurface(start);
          if (part > 1 - kOnSurface) PutOnSurface(start + by);
          const auto [cut, is_new] = cuts_.try_emplace(KeyOf(start, step), Cut{part, part});
          if (is_new) continue;
          cut->second.first = std::min(cut->second.first, part);
          cut->second.last = std::max(cut->second.last, part);
        }
  }
}

double Crossings::CutFrom(const Point& from, const Point& to) const {
  const auto* step = std::ranges::find(kSteps, Point(to - from));
  CDB_CHECK(step != std::end(kSteps));
  const auto number = static_cast<std::size_t>(step - std::begin(kSteps));
  const bool is_forward = number < kForward;
  const Point& start = is_forward ? from : to;
  const auto cut = cuts_.find(KeyOf(start, is_forward ? number : number - kForward));
  if (cut == cuts_.end()) return 0.5;  // rounding decided about an edge of the mesh
  const double part = SignOf(start) > 0 ? cut->second.first : cut->second.last;
  return is_forward ? part : 1 - part;
}

}  // namespace cdb::tetrahedra
