#include "library/terrain/zero_set.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "library/scene_error.h"

namespace cdb::terrain {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Points at which the triangles are compared with the formula.
constexpr std::size_t kMostHeightsCompared = 2'000'000, kMostPointsCompared = 100'000;

/// Barycentric coordinates of points over a triangle: beside its sides, as those on a sharp edge
/// are neither inside nor outside, and between.
constexpr std::array<std::array<double, 3>, 7> kPlaces = {{{1.0 / 3, 1.0 / 3, 1.0 / 3},
                                                           {0.49, 0.49, 0.02},
                                                           {0.49, 0.02, 0.49},
                                                           {0.02, 0.49, 0.49},
                                                           {0.6, 0.2, 0.2},
                                                           {0.2, 0.6, 0.2},
                                                           {0.2, 0.2, 0.6}}};

double Finite(const Function& function, const Vector3d& at) {
  const double value = function(at);
  if (std::isfinite(value)) return value;
  throw library::SceneError(
      fmt::format("the formula has no finite value at ({:.6g}, {:.6g}, {:.6g})", at.x(), at.y(),
                  at.z()),
      "keep away from divisions by 0 and roots of negative numbers, such as by max(0, …), or make "
      "the ground smaller");
}

/// Cells of at most `cell` along a side.
std::size_t CellsAlong(double side, double cell) {
  const double cells = std::ceil(side / cell * (1 - 1e-12));
  return static_cast<std::size_t>(std::clamp(cells, 1.0, 1e9));
}

void CheckPoints(const std::array<std::size_t, 3>& cells, double cell) {
  double points = 1;
  for (const std::size_t count : cells) points *= static_cast<double>(count) + 1;
  const auto most = static_cast<double>(kMaxGridPoints);
  if (points <= most) return;
  const int dimensions = cells[1] > 0 ? 3 : 2;
  throw library::SceneError(
      fmt::format("the formula would be evaluated at {:.3g} points; {} is the maximum", points,
                  kMaxGridPoints),
      fmt::format("make the cell larger, such as `cell: {:.2g}`",
                  1.1 * cell * std::pow(points / most, 1.0 / dimensions)));
}

/// The grid on which the zero set is found: the box, with cells without thickness around it.
class Grid {
 public:
  using Index = std::array<std::size_t, 3>;

  Grid(const Function& function, const AlignedBox3d& box, double cell)
      : function_(function), box_(box) {
    Index cells;
    for (int axis = 0; axis < 3; ++axis) cells[axis] = CellsAlong(box.sizes()[axis], cell);
    CheckPoints(cells, cell);
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double>& at = at_[axis];
      at.push_back(box.min()[axis]);
      for (std::size_t i = 0; i <= cells[axis]; ++i)
        at.push_back(box.min()[axis] +
                     box.sizes()[axis] * static_cast<double>(i) / static_cast<double>(cells[axis]));
      at.push_back(at.back());
      step_[axis] = box.sizes()[axis] / static_cast<double>(cells[axis]);
    }
    FillValues();
  }

  /// Points along each axis; the first and the last two are at the same place.
  std::size_t Points(int axis) const { return at_[axis].size(); }
  Vector3d At(const Index& i) const { return {at_[0][i[0]], at_[1][i[1]], at_[2][i[2]]}; }
  bool IsInside(const Index& i) const { return is_inside_[Flat(i)] != 0; }
  const Vector3d& step() const { return step_; }
  /// Of a cell or a point.
  std::size_t Flat(const Index& i) const { return (i[0] * Points(1) + i[1]) * Points(2) + i[2]; }
  double Value(const Vector3d& at) const {
    return Finite(function_, at.cwiseMax(box_.min()).cwiseMin(box_.max()));
  }
  /// By differences within the box.
  Vector3d Gradient(const Vector3d& at) const {
    Vector3d gradient;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d way = 1e-4 * step_[axis] * Vector3d::Unit(axis);
      const Vector3d after = (at + way).cwiseMin(box_.max()),
                     before = (at - way).cwiseMax(box_.min());
      gradient[axis] = (Value(after) - Value(before)) / (after[axis] - before[axis]);
    }
    return gradient;
  }
  /// Where the sign changes between a point inside and one outside.
  Vector3d Crossing(Vector3d inside, Vector3d outside) const {
    constexpr int kSteps = 40;
    for (int i = 0; i < kSteps; ++i) {
      const Vector3d middle = (inside + outside) / 2;
      (Value(middle) < 0 ? inside : outside) = middle;
    }
    return (inside + outside) / 2;
  }

 private:
  void FillValues() {
    is_inside_.resize(Points(0) * Points(1) * Points(2));
    std::size_t inside = 0, all = 0;
    const auto own = [&](int axis, std::size_t i) {
      return std::clamp(i, std::size_t{1}, Points(axis) - 2);
    };
    for (Index i = {0, 0, 0}; i[0] < Points(0); ++i[0])
      for (i[1] = 0; i[1] < Points(1); ++i[1])
        for (i[2] = 0; i[2] < Points(2); ++i[2]) {
          const bool is_own = i[0] == own(0, i[0]) && i[1] == own(1, i[1]) && i[2] == own(2, i[2]);
          if (!is_own) continue;
          const bool is_in = Finite(function_, At(i)) < 0;
          is_inside_[Flat(i)] = is_in ? 1 : 0;
          inside += is_in ? 1 : 0;
          ++all;
        }
    if (inside == 0 || inside == all)
      throw library::SceneError(
          fmt::format("the formula is {} at all {} points of its grid, so that it has no surface "
                      "in the box",
                      inside == 0 ? "not negative" : "negative", all),
          "move or enlarge the box, by lower and upper, or make the cell smaller: the surface is "
          "where the formula changes its sign");
    for (Index i = {0, 0, 0}; i[0] < Points(0); ++i[0])
      for (i[1] = 0; i[1] < Points(1); ++i[1])
        for (i[2] = 0; i[2] < Points(2); ++i[2])
          is_inside_[Flat(i)] = is_inside_[Flat({own(0, i[0]), own(1, i[1]), own(2, i[2])})];
  }

  const Function& function_;
  const AlignedBox3d box_;
  std::array<std::vector<double>, 3> at_;
  Vector3d step_;
  std::vector<std::uint8_t> is_inside_;  ///< by point
};

using Index = Grid::Index;

Index Beside(Index i, int axis) {
  ++i[static_cast<std::size_t>(axis)];
  return i;
}

/// The vertex of a cell: nearest to the tangent planes where its edges cross the surface.
class CellVertex {
 public:
  CellVertex(const Grid& grid, const Index& cell) : grid_(grid) {
    const Index last = Beside(Beside(Beside(cell, 0), 1), 2);
    box_ = AlignedBox3d(grid.At(cell), grid.At(last));
    for (int axis = 0; axis < 3; ++axis)
      for (unsigned side = 0; side < 4; ++side) {
        Index from = cell;
        if ((side & 1) != 0) from = Beside(from, (axis + 1) % 3);
        if ((side & 2) != 0) from = Beside(from, (axis + 2) % 3);
        AddEdge(from, Beside(from, axis), axis);
      }
  }

  Vector3d Place() const {
    const Vector3d mean = sum_ / count_;
    // About the mean, along the axes in which the planes determine a place.
    Matrix3d normals = normals_;
    Vector3d heights = heights_ - normals_ * mean;
    for (int axis = 0; axis < 3; ++axis)  // a cell without thickness has one place along it
      if (!(box_.sizes()[axis] > 0)) {
        normals.row(axis).setZero();
        normals.col(axis).setZero();
        heights[axis] = 0;
      }
    const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(normals);
    constexpr double kFlat = 0.02;  // a square of sines
    Vector3d way = Vector3d::Zero();
    for (int i = 0; i < 3; ++i) {
      const double weight = axes.eigenvalues()[i];
      const Vector3d axis = axes.eigenvectors().col(i);
      if (weight > kFlat * axes.eigenvalues()[2]) way += axis * (axis.dot(heights) / weight);
    }
    Vector3d place = mean + way;
    if (!place.allFinite() || !box_.contains(place)) place = Clamped(mean);
    return OntoSurface(place);
  }

 private:
  void AddEdge(const Index& from, const Index& to, int axis) {
    const bool is_from_inside = grid_.IsInside(from);
    if (is_from_inside == grid_.IsInside(to)) return;
    const Vector3d a = grid_.At(from), b = grid_.At(to);
    const Vector3d at = is_from_inside ? grid_.Crossing(a, b) : grid_.Crossing(b, a);
    const Vector3d gradient = grid_.Gradient(at);
    const double slope = gradient.norm();
    const Vector3d normal = slope > 0 ? Vector3d(gradient / slope) : Vector3d(Vector3d::Unit(axis));
    normals_ += normal * normal.transpose();
    heights_ += normal * normal.dot(at);
    sum_ += at;
    ++count_;
  }
  Vector3d Clamped(const Vector3d& at) const {
    return at.cwiseMax(box_.min()).cwiseMin(box_.max());
  }
  /// By Newton's steps along the gradient, while they lead nearer to 0.
  Vector3d OntoSurface(Vector3d at) const {
    double value = grid_.Value(at);
    constexpr int kSteps = 3;
    for (int i = 0; i < kSteps && value != 0; ++i) {
      const Vector3d gradient = grid_.Gradient(at);
      const Vector3d next = Clamped(at - value / gradient.squaredNorm() * gradient);
      if (!next.allFinite()) break;
      const double there = grid_.Value(next);
      if (!(std::abs(there) < std::abs(value))) break;
      at = next;
      value = there;
    }
    return at;
  }

  const Grid& grid_;
  AlignedBox3d box_;
  Matrix3d normals_ = Matrix3d::Zero();
  Vector3d heights_ = Vector3d::Zero(), sum_ = Vector3d::Zero();
  double count_ = 0;
};

class Contouring {
 public:
  explicit Contouring(const Grid& grid) : grid_(grid) {
    vertex_.assign(grid.Points(0) * grid.Points(1) * grid.Points(2), kNone);
  }

  meshes::Mesh Make() {
    // Edges in the outermost layers have no cells beyond; those inside of them have the same signs.
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      Index i;
      for (i[At(axis)] = 0; i[At(axis)] + 1 < grid_.Points(axis); ++i[At(axis)])
        for (i[At(u)] = 1; i[At(u)] + 1 < grid_.Points(u); ++i[At(u)])
          for (i[At(v)] = 1; i[At(v)] + 1 < grid_.Points(v); ++i[At(v)]) AddEdge(i, axis, u, v);
    }
    return std::move(mesh_);
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  static std::size_t At(int axis) { return static_cast<std::size_t>(axis); }

  void AddEdge(const Index& from, int axis, int u, int v) {
    const bool is_inside = grid_.IsInside(from);
    if (is_inside == grid_.IsInside(Beside(from, axis))) return;
    const auto cell = [&](std::size_t before_u, std::size_t before_v) {
      Index i = from;
      i[At(u)] -= before_u;
      i[At(v)] -= before_v;
      return VertexOf(i);
    };
    // Counter-clockwise from the end of the edge.
    std::array<std::uint32_t, 4> corner = {cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0)};
    if (!is_inside) std::swap(corner[1], corner[3]);
    const auto length = [&](std::size_t a, std::size_t b) {
      return (mesh_.vertices[corner[a]] - mesh_.vertices[corner[b]]).squaredNorm();
    };
    if (length(1, 3) < length(0, 2)) std::rotate(corner.begin(), corner.begin() + 1, corner.end());
    mesh_.triangles.push_back({corner[0], corner[1], corner[2]});
    mesh_.triangles.push_back({corner[0], corner[2], corner[3]});
  }

  std::uint32_t VertexOf(const Index& cell) {
    std::uint32_t& vertex = vertex_[grid_.Flat(cell)];
    if (vertex == kNone) {
      vertex = static_cast<std::uint32_t>(mesh_.vertices.size());
      mesh_.vertices.push_back(CellVertex(grid_, cell).Place());
    }
    return vertex;
  }

  const Grid& grid_;
  std::vector<std::uint32_t> vertex_;  ///< by cell
  meshes::Mesh mesh_;
};

/// m: from a point along a unit vector, on either side, to the next change of sign; `far` if there
/// is none so near.
double ToChange(const Grid& grid, const Vector3d& at, const Vector3d& normal, double far) {
  const bool is_inside = grid.Value(at) < 0;
  for (double reach = 1e-5 * far;; reach *= 2) {
    const double within = std::min(reach, far);
    for (const double sign : {-1.0, 1.0}) {
      const Vector3d there = at + sign * within * normal;
      if ((grid.Value(there) < 0) == is_inside) continue;
      const Vector3d change = is_inside ? grid.Crossing(at, there) : grid.Crossing(there, at);
      return (change - at).norm();
    }
    if (within == far) return far;
  }
}

Deviation DeviationOf(const Grid& grid, const meshes::Mesh& mesh) {
  Deviation deviation;
  const double far = grid.step().norm();
  const std::size_t stride = mesh.triangles.size() * kPlaces.size() / kMostPointsCompared + 1;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += stride) {
    const auto [a, b, c] = meshes::CornersOf(mesh, mesh.triangles[i]);
    const Vector3d across = (b - a).cross(c - a);
    // A thinner one is a line between its neighbours, and its normal rounding.
    if (!(across.norm() > 1e-6 * far * far)) continue;
    for (const auto& place : kPlaces) {
      const Vector3d at = place[0] * a + place[1] * b + place[2] * c;
      deviation.most = std::max(deviation.most, ToChange(grid, at, across.normalized(), far));
      ++deviation.points;
    }
  }
  return deviation;
}

}  // namespace

HeightGrid HeightsOf(const Function& function, double width, double depth, double cell,
                     Deviation& deviation) {
  const std::size_t across = CellsAlong(width, cell), along = CellsAlong(depth, cell);
  CheckPoints({across, 0, along}, cell);
  HeightGrid grid;
  grid.columns = across + 1;
  grid.rows = along + 1;
  grid.scale = {width / static_cast<double>(across), 1, depth / static_cast<double>(along)};
  const auto place = [&](double column, double row) {
    return Vector3d(grid.scale.x() * column - width / 2, 0, grid.scale.z() * row - depth / 2);
  };
  grid.heights.reserve(grid.columns * grid.rows);
  for (std::size_t row = 0; row < grid.rows; ++row)
    for (std::size_t column = 0; column < grid.columns; ++column)
      grid.heights.push_back(
          Finite(function, place(static_cast<double>(column), static_cast<double>(row))));
  const std::size_t stride = grid.cells() * 2 * kPlaces.size() / kMostHeightsCompared + 1;
  for (std::size_t i = 0; i < grid.cells(); i += stride) {
    const std::size_t column = i % across, row = i / across;
    // The triangles of HeightSurface.
    const std::array<std::array<std::size_t, 2>, 3> corners[2] = {{{{0, 0}, {0, 1}, {1, 0}}},
                                                                  {{{1, 0}, {0, 1}, {1, 1}}}};
    for (const auto& triangle : corners)
      for (const auto& part : kPlaces) {
        double x = 0, z = 0, height = 0;
        for (std::size_t k = 0; k < 3; ++k) {
          const std::size_t at_column = column + triangle[k][0], at_row = row + triangle[k][1];
          x += part[k] * static_cast<double>(at_column);
          z += part[k] * static_cast<double>(at_row);
          height += part[k] * grid.heights[at_row * grid.columns + at_column];
        }
        deviation.most = std::max(deviation.most, std::abs(Finite(function, place(x, z)) - height));
        ++deviation.points;
      }
  }
  return grid;
}

meshes::Mesh ZeroSetOf(const Function& function, const Eigen::AlignedBox3d& box, double cell,
                       Deviation& deviation) {
  const Grid grid(function, box, cell);
  meshes::Mesh mesh = Contouring(grid).Make();
  deviation = DeviationOf(grid, mesh);
  return mesh;
}

}  // namespace cdb::terrain
