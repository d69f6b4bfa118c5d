#include "library/tetrahedra/stuffing.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "dsl/text/check.h"
#include "library/meshes/union_find.h"
#include "library/scene_error.h"
#include "library/tetrahedra/lattice.h"

namespace cdb::tetrahedra {
namespace {

using Eigen::Vector3d;
using Corners = std::array<std::uint32_t, 4>;

/// A corner of the lattice moves to a cut point closer than this part of a long, or a short edge.
constexpr double kWarpLong = 0.24999, kWarpShort = 0.41189;
/// Smaller pieces beside the largest are dropped if all of them have less of its volume.
constexpr double kDroppedVolume = 0.01;

/// The triangles of a tetrahedron of positive volume, counter-clockwise from outside.
constexpr std::array<std::size_t, 3> kFaces[] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

double VolumeOf(const std::vector<Vector3d>& nodes, const Corners& t) {
  return (nodes[t[1]] - nodes[t[0]])
             .cross(nodes[t[2]] - nodes[t[0]])
             .dot(nodes[t[3]] - nodes[t[0]]) /
         6;
}

/// The least angle between two faces, and the largest.
DihedralAngles AnglesOf(const std::array<Vector3d, 4>& at) {
  DihedralAngles angles;
  std::array<Vector3d, 4> outwards;
  for (std::size_t face = 0; face < 4; ++face) {
    const auto& [a, b, c] = kFaces[face];
    outwards[face] = (at[b] - at[a]).cross(at[c] - at[a]).normalized();
  }
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) {
      const double angle =
          180 - std::atan2(outwards[i].cross(outwards[j]).norm(), outwards[i].dot(outwards[j])) *
                    180 / std::numbers::pi;
      angles.least = std::min(angles.least, angle);
      angles.most = std::max(angles.most, angle);
    }
  return angles;
}

/// Moves the corners of the lattice, and makes the tetrahedra.
class Stuffing {
 public:
  Stuffing(const Lattice& lattice, const meshes::Mesh& mesh, std::string_view name)
      : lattice_(lattice), crossings_(lattice, mesh), name_(name) {}

  Tetrahedra Take() {
    Warp();
    Fill();
    made_.cell = lattice_.cell();
    return std::move(made_);
  }

 private:
  int Sign(const Point& point) const { return crossings_.SignOf(point); }

  void Warp() {
    lattice_.ForEachPoint([&](const Point& point) {
      const int sign = Sign(point);
      if (sign == 0) return;
      double nearest = std::numeric_limits<double>::infinity();
      Vector3d to = Vector3d::Zero();
      for (const Point& step : Lattice::Steps()) {
        const Point other = point + step;
        if (!lattice_.Has(other) || Sign(other) != -sign) continue;
        const double cut = crossings_.CutFrom(point, other);
        if (!(cut < (Lattice::IsLong(step) ? kWarpLong : kWarpShort))) continue;
        const double length = cut * step.cast<double>().norm();
        if (!(length < nearest)) continue;
        nearest = length;
        to = lattice_.PlaceOf(point) + cut * (lattice_.PlaceOf(other) - lattice_.PlaceOf(point));
      }
      if (!std::isfinite(nearest)) return;
      warped_[lattice_.IndexOf(point)] = to;
      crossings_.PutOnSurface(point);
    });
  }

  std::uint32_t AddNode(const Vector3d& place) {
    if (made_.nodes.size() == kMostNodes)
      throw library::SceneError(
          fmt::format("{}: its tetrahedra have more than {} nodes", name_, kMostNodes),
          "use fewer cells");
    made_.nodes.push_back(place);
    return static_cast<std::uint32_t>(made_.nodes.size() - 1);
  }

  std::uint32_t NodeAt(const Point& point) {
    const std::size_t index = lattice_.IndexOf(point);
    const auto [node, is_new] = nodes_.try_emplace(index, 0);
    if (is_new) {
      const auto moved = warped_.find(index);
      node->second = AddNode(moved != warped_.end() ? moved->second : lattice_.PlaceOf(point));
    }
    return node->second;
  }

  /// `inside` is inside, `outside` is outside.
  std::uint32_t CutBetween(const Point& inside, const Point& outside) {
    const auto [node, is_new] =
        cuts_.try_emplace({lattice_.IndexOf(inside), lattice_.IndexOf(outside)}, 0);
    if (is_new) {
      const Vector3d from = lattice_.PlaceOf(inside);
      node->second =
          AddNode(from + crossings_.CutFrom(inside, outside) * (lattice_.PlaceOf(outside) - from));
    }
    return node->second;
  }

  void Add(Corners corners) {
    if (VolumeOf(made_.nodes, corners) < 0) std::swap(corners[2], corners[3]);
    made_.corners.push_back(corners);
  }

  /// Each tetrahedron of the lattice has a long edge of either of its two cubic grids.
  void Fill() {
    lattice_.ForEachPoint([&](const Point& point) {
      if (point.x() % 2 != 0) return;
      for (int axis = 0; axis < 3; ++axis) {
        const Point along = Point::Unit(axis), first = Point::Unit((axis + 1) % 3),
                    second = Point::Unit((axis + 2) % 3);
        const Point end = point + 2 * along;
        if (!lattice_.Has(end)) continue;
        const Point ring[] = {point + along + first + second, point + along - first + second,
                              point + along - first - second, point + along + first - second};
        for (std::size_t i = 0; i < 4; ++i) {
          const Point &a = ring[i], &b = ring[(i + 1) % 4];
          if (lattice_.Has(a) && lattice_.Has(b)) FillOne({point, end, a, b});
        }
      }
    });
  }

  void FillOne(std::array<Point, 4> points) {
    std::ranges::stable_sort(points, std::ranges::greater(),
                             [&](const Point& point) { return Sign(point); });
    const auto count = [&](int sign) {
      return std::ranges::count_if(points, [&](const Point& p) { return Sign(p) == sign; });
    };
    const auto inside = count(1), outside = count(-1);
    const auto& [a, b, c, d] = points;
    if (inside == 0) return;
    if (outside == 0) {
      Add({NodeAt(a), NodeAt(b), NodeAt(c), NodeAt(d)});
    } else if (inside == 1) {
      Corners corners = {NodeAt(a), 0, 0, 0};
      for (std::size_t i = 1; i < 4; ++i)
        corners[i] = Sign(points[i]) == 0 ? NodeAt(points[i]) : CutBetween(a, points[i]);
      Add(corners);
    } else if (inside == 2 &&
               outside == 1) {  // a pyramid over a quadrilateral; c is on the surface
      const std::uint32_t at_a = CutBetween(a, d), at_b = CutBetween(b, d), top = NodeAt(c);
      if (IsDiagonalFrom(a, b, d)) {
        Add({NodeAt(a), NodeAt(b), at_b, top});
        Add({NodeAt(a), at_b, at_a, top});
      } else {
        Add({NodeAt(b), NodeAt(a), at_a, top});
        Add({NodeAt(b), at_a, at_b, top});
      }
    } else if (inside == 2) {
      FillBetweenEdges(points);
    } else {
      const std::array<std::uint32_t, 3> low = {NodeAt(a), NodeAt(b), NodeAt(c)},
                                         high = {CutBetween(a, d), CutBetween(b, d),
                                                 CutBetween(c, d)};
      const bool ab = IsDiagonalFrom(a, b, d), bc = IsDiagonalFrom(b, c, d),
                 ac = IsDiagonalFrom(a, c, d);
      for (const Corners& corners : Prism(low, high, ab, bc, ac)) Add(corners);
    }
  }

  /// a and b are inside, c and d outside: a prism, one of whose quadrilaterals is on the surface.
  void FillBetweenEdges(const std::array<Point, 4>& points) {
    const auto& [a, b, c, d] = points;
    const std::array<std::uint32_t, 3> low = {NodeAt(a), CutBetween(a, c), CutBetween(a, d)},
                                       high = {NodeAt(b), CutBetween(b, c), CutBetween(b, d)};
    const bool to_c = IsDiagonalFrom(a, b, c), to_d = IsDiagonalFrom(a, b, d);
    std::vector<Corners> best;
    double best_angle = -1;
    for (const bool cd : {true, false}) {
      // A cycle of diagonals leaves no tetrahedra.
      if ((to_c && cd && !to_d) || (!to_c && !cd && to_d)) continue;
      const std::vector<Corners> tried = Prism(low, high, to_c, cd, to_d);
      double least = 180;
      for (Corners corners : tried) {
        if (VolumeOf(made_.nodes, corners) < 0) std::swap(corners[2], corners[3]);
        std::array<Vector3d, 4> at;
        for (std::size_t i = 0; i < 4; ++i) at[i] = made_.nodes[corners[i]];
        const DihedralAngles angles = AnglesOf(at);
        least = std::min({least, angles.least, 180 - angles.most});
      }
      if (least > best_angle) {
        best_angle = least;
        best = tried;
      }
    }
    for (const Corners& corners : best) Add(corners);
  }

  /// The tetrahedra of a prism. `ab`: the diagonal of the quadrilateral over the first two corners
  /// is from low[0] to high[1], otherwise from low[1] to high[0]; `bc` and `ac` likewise. They must
  /// not form a cycle.
  static std::vector<Corners> Prism(const std::array<std::uint32_t, 3>& low,
                                    const std::array<std::uint32_t, 3>& high, bool ab, bool bc,
                                    bool ac) {
    // A diagonal from low[x] to high[y] puts x before y.
    const int before[3] = {!ab + !ac, ab + !bc, ac + bc};
    std::array<std::size_t, 3> order = {3, 3, 3};
    for (std::size_t i = 0; i < 3; ++i) order[static_cast<std::size_t>(before[i])] = i;
    CDB_CHECK(order[0] < 3 && order[1] < 3 && order[2] < 3);
    const auto& [x, y, z] = order;
    return {{low[x], low[y], low[z], high[z]},
            {low[x], low[y], high[y], high[z]},
            {low[x], high[x], high[y], high[z]}};
  }

  /// u and v are inside, w outside, in one face: whether the diagonal of the quadrilateral starts
  /// at u. It depends on the face alone, so that both of its tetrahedra agree.
  static bool IsDiagonalFrom(const Point& u, const Point& v, const Point& w) {
    if (Lattice::IsLong(u - v)) return (u.sum() - 3 * (u.x() % 2)) / 2 % 2 == 0;
    return Lattice::IsLong(u - w);
  }

  struct HashOfPair {
    std::size_t operator()(const std::pair<std::size_t, std::size_t>& pair) const {
      return pair.first * 0x9e3779b97f4a7c15ULL ^ pair.second;
    }
  };

  const Lattice& lattice_;
  Crossings crossings_;
  const std::string_view name_;
  std::unordered_map<std::size_t, Vector3d> warped_;
  std::unordered_map<std::size_t, std::uint32_t> nodes_;
  std::unordered_map<std::pair<std::size_t, std::size_t>, std::uint32_t, HashOfPair> cuts_;
  Tetrahedra made_;
};

/// A face of a tetrahedron, by its sorted corners.
struct Face {
  std::array<std::uint32_t, 3> sorted;
  std::uint32_t tetrahedron;
};

std::vector<Face> SortedFaces(const std::vector<Corners>& all) {
  std::vector<Face> faces;
  faces.reserve(4 * all.size());
  for (std::uint32_t i = 0; i < all.size(); ++i)
    for (const auto& [a, b, c] : kFaces) {
      Face face{{all[i][a], all[i][b], all[i][c]}, i};
      std::ranges::sort(face.sorted);
      faces.push_back(face);
    }
  std::ranges::sort(faces, {},
                    [](const Face& face) { return std::pair(face.sorted, face.tetrahedron); });
  return faces;
}

/// The pairs of tetrahedra that share a face.
std::vector<std::pair<std::uint32_t, std::uint32_t>> NeighboursOf(const std::vector<Corners>& all) {
  const std::vector<Face> faces = SortedFaces(all);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (std::size_t i = 0; i + 1 < faces.size(); ++i)
    if (faces[i].sorted == faces[i + 1].sorted)
      pairs.emplace_back(faces[i].tetrahedron, faces[i + 1].tetrahedron);
  return pairs;
}

/// Removes the smaller of tetrahedra that meet only at an edge, until there are none.
void SeparateAtEdges(Tetrahedra& made) {
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    struct Use {
      std::uint32_t low, high, tetrahedron;
    };
    std::vector<Use> uses;
    for (std::uint32_t i = 0; i < made.corners.size(); ++i)
      for (std::size_t j = 0; j < 4; ++j)
        for (std::size_t k = j + 1; k < 4; ++k) {
          const auto [low, high] = std::minmax(made.corners[i][j], made.corners[i][k]);
          uses.push_back({low, high, i});
        }
    std::ranges::sort(
        uses, {}, [](const Use& use) { return std::tuple(use.low, use.high, use.tetrahedron); });
    std::vector<char> is_removed(made.corners.size(), 0);
    for (std::size_t begin = 0, end; begin < uses.size(); begin = end) {
      for (end = begin; end < uses.size() && uses[end].low == uses[begin].low &&
                        uses[end].high == uses[begin].high;)
        ++end;
      meshes::UnionFind fans(end - begin);
      for (std::size_t i = begin; i < end; ++i)
        for (std::size_t j = i + 1; j < end; ++j) {
          std::size_t shared = 0;
          for (const std::uint32_t corner : made.corners[uses[i].tetrahedron])
            shared += std::ranges::count(made.corners[uses[j].tetrahedron], corner) > 0;
          if (shared == 3)
            fans.Join(static_cast<std::uint32_t>(i - begin), static_cast<std::uint32_t>(j - begin));
        }
      std::vector<double> volumes(end - begin, 0.0);
      for (std::size_t i = begin; i < end; ++i)
        volumes[fans.Root(static_cast<std::uint32_t>(i - begin))] +=
            VolumeOf(made.nodes, made.corners[uses[i].tetrahedron]);
      const auto largest =
          static_cast<std::uint32_t>(std::ranges::max_element(volumes) - volumes.begin());
      for (std::size_t i = begin; i < end; ++i)
        if (fans.Root(static_cast<std::uint32_t>(i - begin)) != largest)
          is_removed[uses[i].tetrahedron] = is_changed = true;
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < made.corners.size(); ++i)
      if (is_removed[i] == 0) made.corners[kept++] = made.corners[i];
    made.corners.resize(kept);
  }
}

/// Keeps the largest of the pieces that are connected by faces.
void KeepLargest(Tetrahedra& made, std::string_view name, std::size_t cells) {
  meshes::UnionFind pieces(made.corners.size());
  for (const auto& [a, b] : NeighboursOf(made.corners)) pieces.Join(a, b);
  std::vector<double> volumes(made.corners.size(), 0.0);
  double whole = 0;
  for (std::uint32_t i = 0; i < made.corners.size(); ++i) {
    const double volume = VolumeOf(made.nodes, made.corners[i]);
    volumes[pieces.Root(i)] += volume;
    whole += volume;
  }
  if (!(whole > 0))
    throw library::SceneError(
        fmt::format("{}: at {} cells, no tetrahedron is left: the mesh is thinner than a cell",
                    name, cells),
        "use more cells");
  const auto largest =
      static_cast<std::uint32_t>(std::ranges::max_element(volumes) - volumes.begin());
  const auto count = std::ranges::count_if(
      volumes, [&](double volume) { return volume > kDroppedVolume * volumes[largest]; });
  if (whole - volumes[largest] > kDroppedVolume * whole)
    throw library::SceneError(
        fmt::format("{}: at {} cells, its tetrahedra are {} pieces that no face connects", name,
                    cells, std::max<std::ptrdiff_t>(count, 2)),
        "use more cells, so that thin parts hold together, or a file for each piece");
  std::size_t kept = 0;
  for (std::uint32_t i = 0; i < volumes.size(); ++i)
    if (pieces.Root(i) == largest) made.corners[kept++] = made.corners[i];
  made.corners.resize(kept);
}

/// Gives tetrahedra that meet only at a node a node each, and drops unused nodes.
void SeparateAtNodes(Tetrahedra& made) {
  // A number for each corner of each tetrahedron; those of one node are joined through faces.
  meshes::UnionFind corners(4 * made.corners.size());
  const auto place_in = [&](std::uint32_t tetrahedron, std::uint32_t node) {
    const Corners& of = made.corners[tetrahedron];
    return static_cast<std::uint32_t>(4 * tetrahedron + (std::ranges::find(of, node) - of.begin()));
  };
  const std::vector<Face> faces = SortedFaces(made.corners);
  for (std::size_t i = 0; i + 1 < faces.size(); ++i)
    if (faces[i].sorted == faces[i + 1].sorted)
      for (const std::uint32_t node : faces[i].sorted)
        corners.Join(place_in(faces[i].tetrahedron, node),
                     place_in(faces[i + 1].tetrahedron, node));
  std::vector<Vector3d> nodes;
  std::vector<std::uint32_t> number(4 * made.corners.size());
  for (std::uint32_t i = 0; i < number.size(); ++i) {
    const std::uint32_t root = corners.Root(i);
    if (root == i) {
      number[i] = static_cast<std::uint32_t>(nodes.size());
      nodes.push_back(made.nodes[made.corners[i / 4][i % 4]]);
    }
    number[i] = number[root];
  }
  for (std::uint32_t i = 0; i < number.size(); ++i) made.corners[i / 4][i % 4] = number[i];
  made.nodes = std::move(nodes);
}

}  // namespace

Tetrahedra Stuff(const meshes::Mesh& mesh, std::size_t cells, std::string_view name) {
  const Lattice lattice(mesh, cells);
  Tetrahedra made = Stuffing(lattice, mesh, name).Take();
  SeparateAtEdges(made);
  KeepLargest(made, name, cells);
  SeparateAtNodes(made);
  return made;
}

DihedralAngles DihedralAnglesOf(const Tetrahedra& tetrahedra) {
  DihedralAngles all;
  for (const Corners& corners : tetrahedra.corners) {
    std::array<Vector3d, 4> at;
    for (std::size_t i = 0; i < 4; ++i) at[i] = tetrahedra.nodes[corners[i]];
    const DihedralAngles angles = AnglesOf(at);
    all.least = std::min(all.least, angles.least);
    all.most = std::max(all.most, angles.most);
  }
  return all;
}

}  // namespace cdb::tetrahedra
