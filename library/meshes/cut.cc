#include "library/meshes/cut.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "library/meshes/mass_properties.h"

namespace cdb::meshes {
namespace {

using Eigen::Vector3d;

/// From one vertex to another.
struct Arc {
  std::uint32_t from, to;
};

/// Arcs less those that occur in both directions.
std::vector<Arc> Net(std::vector<Arc> arcs) {
  std::sort(arcs.begin(), arcs.end(), [](const Arc& a, const Arc& b) {
    return std::minmax(a.from, a.to) < std::minmax(b.from, b.to);
  });
  std::vector<Arc> net;
  for (std::size_t begin = 0, end; begin < arcs.size(); begin = end) {
    const auto [low, high] = std::minmax(arcs[begin].from, arcs[begin].to);
    int rising = 0;
    for (end = begin; end < arcs.size() && std::min(arcs[end].from, arcs[end].to) == low &&
                      std::max(arcs[end].from, arcs[end].to) == high;
         ++end)
      rising += arcs[end].from == low ? 1 : -1;
    for (; rising > 0; --rising) net.push_back({low, high});
    for (; rising < 0; ++rising) net.push_back({high, low});
  }
  return net;
}

/// Joins loops of the boundary that a line meets at the two ends of an interval inside.
void JoinAcross(const std::vector<Arc>& boundary, const std::vector<Vector3d>& vertices, int along,
                int across, UnionFind& regions) {
  struct Extent {
    double low, high;
  };
  std::vector<std::pair<std::uint32_t, Extent>> loops;
  for (const Arc& arc : boundary) {
    const auto [low, high] = std::minmax(vertices[arc.from][across], vertices[arc.to][across]);
    loops.push_back({regions.Root(arc.from), {low, high}});
  }
  std::sort(loops.begin(), loops.end(), [](const auto& a, const auto& b) {
    return std::tie(a.first, a.second.low, a.second.high) <
           std::tie(b.first, b.second.low, b.second.high);
  });
  std::vector<double> lines;
  for (std::size_t begin = 0, end; begin < loops.size(); begin = end) {
    Extent extent = loops[begin].second;
    for (end = begin; end < loops.size() && loops[end].first == loops[begin].first; ++end)
      extent.high = std::max(extent.high, loops[end].second.high);
    for (const double part : {0.237, 0.513, 0.763})
      lines.push_back(extent.low + part * (extent.high - extent.low));
  }
  // More lines would take too long.
  constexpr std::size_t kMostLines = 1000;
  const std::size_t step = lines.size() / kMostLines + 1;
  struct Hit {
    double at;
    int turns;
    std::uint32_t vertex;
  };
  std::vector<Hit> hits;
  for (std::size_t i = 0; i < lines.size(); i += step) {
    const double line = lines[i];
    hits.clear();
    for (const Arc& arc : boundary) {
      const Vector3d &a = vertices[arc.from], &b = vertices[arc.to];
      if ((a[across] <= line) == (b[across] <= line)) continue;
      const double part = (line - a[across]) / (b[across] - a[across]);
      hits.push_back(
          {a[along] + part * (b[along] - a[along]), a[across] <= line ? 1 : -1, arc.from});
    }
    std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) {
      return std::tie(a.at, a.vertex, a.turns) < std::tie(b.at, b.vertex, b.turns);
    });
    int winding = 0;
    for (std::size_t k = 0; k + 1 < hits.size(); ++k) {
      winding += hits[k].turns;
      if (winding != 0) regions.Join(hits[k].vertex, hits[k + 1].vertex);
    }
  }
}

/// Adds fans with this boundary, one for each connected region of the plane.
void AppendCap(const std::vector<Arc>& boundary, std::int32_t cap, Piece& side) {
  if (boundary.empty()) return;
  const std::vector<Vector3d>& vertices = side.mesh.vertices;
  UnionFind regions(vertices.size());
  for (const Arc& arc : boundary) regions.Join(arc.from, arc.to);
  // Lines are along the two axes in which the region is largest.
  Vector3d area = Vector3d::Zero();
  const Vector3d& origin = vertices[boundary[0].from];
  for (const Arc& arc : boundary)
    area += (vertices[arc.from] - origin).cross(vertices[arc.to] - origin);
  int steepest = 0;
  area.cwiseAbs().maxCoeff(&steepest);
  const int u = (steepest + 1) % 3, v = (steepest + 2) % 3;
  JoinAcross(boundary, vertices, u, v, regions);
  JoinAcross(boundary, vertices, v, u, regions);
  std::vector<std::uint32_t> apex(vertices.size(), kNoVertex);
  for (const Arc& arc : boundary) {
    std::uint32_t& from = apex[regions.Root(arc.from)];
    if (from == kNoVertex) from = arc.from;
    if (arc.from == from || arc.to == from) continue;
    side.mesh.triangles.push_back({from, arc.from, arc.to});
    side.caps.push_back(cap);
  }
}

/// By cap in ascending order, the numbers of its triangles.
std::vector<std::pair<std::int32_t, std::vector<std::uint32_t>>> TrianglesByCap(
    const std::vector<std::int32_t>& caps) {
  std::vector<std::pair<std::int32_t, std::vector<std::uint32_t>>> by_cap;
  std::vector<std::int32_t> sorted = caps;
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  for (const std::int32_t cap : sorted)
    if (cap != kSurface) by_cap.push_back({cap, {}});
  for (std::uint32_t i = 0; i < caps.size(); ++i)
    if (caps[i] != kSurface)
      std::lower_bound(by_cap.begin(), by_cap.end(), caps[i], [](const auto& a, std::int32_t cap) {
        return a.first < cap;
      })->second.push_back(i);
  return by_cap;
}

/// The part of a line above (`sign` 1) or below a plane.
bool Clip(Excess& excess, const Plane& plane, int sign) {
  const double from = sign * plane.Above(excess.from), to = sign * plane.Above(excess.to);
  if (from <= 0 && to <= 0) return false;
  const Vector3d at = from * to < 0
                          ? Vector3d(excess.from + from / (from - to) * (excess.to - excess.from))
                          : excess.from;
  if (from < 0) excess.from = at;
  if (to < 0) excess.to = at;
  return true;
}

class Cutter {
 public:
  Cutter(const Piece& piece, const Plane& plane, double flat) : piece_(piece), plane_(plane) {
    vertices_ = piece.mesh.vertices;
    for (const Vector3d& vertex : vertices_) {
      above_.push_back(plane.Above(vertex));
      sides_.push_back(std::abs(above_.back()) <= flat ? 0 : above_.back() > 0 ? 1 : -1);
    }
    FindCrossings();
  }

  /// `sign`: 1 above, -1 below.
  Piece Closed(int sign, std::int32_t cut) const {
    const Piece side = Clipped(sign);
    // Caps that the plane cuts are made anew: the fan of the old one could connect parts.
    std::vector<Arc> section;
    Piece closed;
    closed.mesh.vertices = vertices_;
    for (Excess excess : piece_.excesses)
      if (Clip(excess, plane_, sign)) closed.excesses.push_back(excess);
    for (std::size_t i = 0; i < side.mesh.triangles.size(); ++i) {
      if (side.caps[i] != kSurface) continue;
      closed.mesh.triangles.push_back(side.mesh.triangles[i]);
      closed.caps.push_back(kSurface);
      AppendArcs(side.mesh.triangles[i], section, nullptr);
    }
    for (const auto& [cap, triangles] : TrianglesByCap(side.caps)) {
      std::vector<Arc> inner, on_plane;
      for (const std::uint32_t i : triangles) AppendArcs(side.mesh.triangles[i], on_plane, &inner);
      std::vector<Arc> boundary = Net(std::move(inner));
      for (const Arc& arc : Straightened(on_plane)) {
        section.push_back(arc);
        boundary.push_back(arc);
      }
      AppendCap(boundary, cap, closed);
    }
    for (Arc& arc : section) std::swap(arc.from, arc.to);
    AppendCap(Net(std::move(section)), cut, closed);
    return closed;
  }

 private:
  void FindCrossings() {
    for (const Triangle& t : piece_.mesh.triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
        if (sides_[low] * sides_[high] < 0) crossings_.push_back({low, high});
      }
    std::sort(crossings_.begin(), crossings_.end());
    crossings_.erase(std::unique(crossings_.begin(), crossings_.end()), crossings_.end());
    for (const auto& [low, high] : crossings_) {
      const double at = above_[low] / (above_[low] - above_[high]);
      vertices_.push_back(vertices_[low] + at * (vertices_[high] - vertices_[low]));
      sides_.push_back(0);
    }
  }

  std::uint32_t Crossing(std::uint32_t a, std::uint32_t b) const {
    const std::pair<std::uint32_t, std::uint32_t> edge = std::minmax(a, b);
    const auto at = std::lower_bound(crossings_.begin(), crossings_.end(), edge);
    return static_cast<std::uint32_t>(piece_.mesh.vertices.size() +
                                      static_cast<std::size_t>(at - crossings_.begin()));
  }

  /// Triangles in the plane are on neither side.
  Piece Clipped(int sign) const {
    Piece side;
    for (std::size_t i = 0; i < piece_.mesh.triangles.size(); ++i) {
      const Triangle& t = piece_.mesh.triangles[i];
      std::array<std::uint32_t, 4> corners{};
      std::size_t count = 0;
      bool reaches = false;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t from = t[k], to = t[(k + 1) % 3];
        reaches = reaches || sides_[from] == sign;
        if (sides_[from] != -sign) corners[count++] = from;
        if (sides_[from] * sides_[to] < 0) corners[count++] = Crossing(from, to);
      }
      if (!reaches) continue;
      for (std::size_t k = 2; k < count; ++k) {
        side.mesh.triangles.push_back({corners[0], corners[k - 1], corners[k]});
        side.caps.push_back(piece_.caps[i]);
      }
    }
    return side;
  }

  void AppendArcs(const Triangle& t, std::vector<Arc>& on_plane, std::vector<Arc>* inner) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const Arc arc{t[k], t[(k + 1) % 3]};
      if (sides_[arc.from] == 0 && sides_[arc.to] == 0)
        on_plane.push_back(arc);
      else if (inner != nullptr)
        inner->push_back(arc);
    }
  }

  /// Arcs along a line, with the vertices at which they do not continue only.
  std::vector<Arc> Straightened(const std::vector<Arc>& arcs) const {
    std::vector<std::pair<std::uint32_t, int>> ends;
    for (const Arc& arc : arcs) {
      ends.emplace_back(arc.from, 1);
      ends.emplace_back(arc.to, -1);
    }
    std::sort(ends.begin(), ends.end());
    struct End {
      double at;
      std::uint32_t vertex;
      int leaving;
    };
    std::vector<End> open;
    for (std::size_t begin = 0, end; begin < ends.size(); begin = end) {
      int leaving = 0;
      for (end = begin; end < ends.size() && ends[end].first == ends[begin].first; ++end)
        leaving += ends[end].second;
      if (leaving != 0) open.push_back({0, ends[begin].first, leaving});
    }
    if (open.empty()) return {};
    // Along the longest axis of their box.
    Eigen::AlignedBox3d box;
    for (const End& end : open) box.extend(vertices_[end.vertex]);
    int axis = 0;
    box.sizes().maxCoeff(&axis);
    for (End& end : open) end.at = vertices_[end.vertex][axis];
    std::sort(open.begin(), open.end(), [](const End& a, const End& b) {
      return a.at != b.at ? a.at < b.at : a.vertex < b.vertex;
    });
    std::vector<Arc> straight;
    int flow = 0;
    for (std::size_t i = 0; i + 1 < open.size(); ++i) {
      flow += open[i].leaving;
      for (int k = 0; k < flow; ++k) straight.push_back({open[i].vertex, open[i + 1].vertex});
      for (int k = 0; k > flow; --k) straight.push_back({open[i + 1].vertex, open[i].vertex});
    }
    return straight;
  }

  const Piece& piece_;
  const Plane& plane_;
  std::vector<Vector3d> vertices_;
  std::vector<double> above_;
  std::vector<int> sides_;  ///< by vertex: 1 above, 0 on, -1 below the plane
  std::vector<std::pair<std::uint32_t, std::uint32_t>> crossings_;
};

/// The triangles with equal labels, each a piece with the vertices that it uses.
std::vector<Piece> Grouped(const Piece& piece, std::span<const std::uint32_t> labels) {
  std::vector<std::uint32_t> part(1 + *std::max_element(labels.begin(), labels.end()), kNoVertex);
  std::vector<std::uint32_t> number(piece.mesh.vertices.size(), kNoVertex), owner(number);
  std::vector<Piece> parts;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    std::uint32_t& at = part[labels[i]];
    if (at == kNoVertex) {
      at = static_cast<std::uint32_t>(parts.size());
      parts.emplace_back();
    }
    Piece& one = parts[at];
    Triangle triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = piece.mesh.triangles[i][k];
      if (owner[vertex] != at) {
        owner[vertex] = at;
        number[vertex] = static_cast<std::uint32_t>(one.mesh.vertices.size());
        one.mesh.vertices.push_back(piece.mesh.vertices[vertex]);
      }
      triangle[k] = number[vertex];
    }
    one.mesh.triangles.push_back(triangle);
    one.caps.push_back(piece.caps[i]);
  }
  return parts;
}

/// Gives each excess to the part round it.
void Distribute(const std::vector<Excess>& excesses, std::vector<Piece>& parts) {
  std::vector<Eigen::AlignedBox3d> boxes(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (const Vector3d& vertex : parts[i].mesh.vertices) boxes[i].extend(vertex);
  for (const Excess& excess : excesses) {
    std::size_t owner = 0;
    const Vector3d middle = (excess.from + excess.to) / 2;
    while (owner + 1 < parts.size() && !boxes[owner].contains(middle)) ++owner;
    parts[owner].excesses.push_back(excess);
  }
}

}  // namespace

double VolumeOf(const Piece& piece) {
  double volume = SignedVolume(piece.mesh);
  for (const Excess& excess : piece.excesses)
    volume -= excess.area * std::sqrt((excess.to - excess.from).squaredNorm());
  return volume;
}

std::vector<Piece> Separated(const Piece& piece, std::span<const std::uint32_t> labels,
                             double least_volume, std::size_t most) {
  std::vector<Piece> parts = Grouped(piece, labels);
  Distribute(piece.excesses, parts);
  std::size_t solid = 0;
  bool has_cavity = false;
  for (Piece& part : parts) {
    part.volume = VolumeOf(part);
    solid += part.volume >= least_volume ? 1 : 0;
    has_cavity = has_cavity || part.volume <= -least_volume;
  }
  if (parts.size() > 1 && (has_cavity || solid > most))
    return Separated(piece, std::vector<std::uint32_t>(labels.size(), 0), least_volume, 1);
  std::erase_if(parts, [&](const Piece& part) { return part.volume < least_volume; });
  return parts;
}

std::vector<Piece> Cut(const Piece& piece, const Plane& plane, std::int32_t cut, double flat,
                       double least_volume, std::size_t most) {
  Cutter cutter(piece, plane, flat);
  std::vector<Piece> pieces;
  for (const int sign : {-1, 1}) {
    Piece side = cutter.Closed(sign, cut);
    if (side.mesh.triangles.empty()) continue;
    UnionFind connected(side.mesh.vertices.size());
    for (const Triangle& t : side.mesh.triangles) {
      connected.Join(t[0], t[1]);
      connected.Join(t[0], t[2]);
    }
    std::vector<std::uint32_t> labels;
    for (const Triangle& t : side.mesh.triangles) labels.push_back(connected.Root(t[0]));
    for (Piece& part : Separated(side, labels, least_volume, most))
      pieces.push_back(std::move(part));
  }
  return pieces;
}

Piece Joined(const Piece& first, const Piece& second) {
  Piece joined = first;
  // Both sides of a cut have the same vertices, to the last bit.
  const auto less = [](const Vector3d& a, const Vector3d& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  };
  std::vector<Vector3d>& vertices = joined.mesh.vertices;
  std::vector<std::uint32_t> order(vertices.size()), number;
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return less(first.mesh.vertices[a], first.mesh.vertices[b]);
  });
  for (const Vector3d& vertex : second.mesh.vertices) {
    const auto at = std::lower_bound(
        order.begin(), order.end(), vertex,
        [&](std::uint32_t a, const Vector3d& b) { return less(first.mesh.vertices[a], b); });
    if (at != order.end() && first.mesh.vertices[*at] == vertex) {
      number.push_back(*at);
    } else {
      number.push_back(static_cast<std::uint32_t>(vertices.size()));
      vertices.push_back(vertex);
    }
  }
  for (const auto& [a, b, c] : second.mesh.triangles)
    joined.mesh.triangles.push_back({number[a], number[b], number[c]});
  joined.caps.insert(joined.caps.end(), second.caps.begin(), second.caps.end());
  joined.excesses.insert(joined.excesses.end(), second.excesses.begin(), second.excesses.end());
  joined.volume += second.volume;
  // The caps between them disappear.
  Piece open = joined;
  joined.mesh.triangles.clear();
  joined.caps.clear();
  for (std::size_t i = 0; i < open.caps.size(); ++i) {
    if (open.caps[i] != kSurface) continue;
    joined.mesh.triangles.push_back(open.mesh.triangles[i]);
    joined.caps.push_back(kSurface);
  }
  for (const auto& [cap, triangles] : TrianglesByCap(open.caps)) {
    std::vector<Arc> arcs;
    for (const std::uint32_t i : triangles)
      for (std::size_t k = 0; k < 3; ++k)
        arcs.push_back({open.mesh.triangles[i][k], open.mesh.triangles[i][(k + 1) % 3]});
    AppendCap(Net(std::move(arcs)), cap, joined);
  }
  return joined;
}

}  // namespace cdb::meshes
