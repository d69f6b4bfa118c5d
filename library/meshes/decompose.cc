#include "library/meshes/decompose.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "dsl/text/check.h"
#include "library/meshes/cut.h"
#include "library/meshes/mass_properties.h"
#include "library/meshes/overlap_volume.h"
#include "library/meshes/quick_hull.h"
#include "library/meshes/topology.h"
#include "library/scene_error.h"

namespace cdb::meshes {
namespace {

using Eigen::Vector3d;

/// To be incremented whenever the same mesh and options would give different pieces or figures.
constexpr int kAlgorithm = 2;
/// A vertex that is closer to a plane is on it, as a fraction of the diagonal of the mesh: files
/// have coordinates of single precision or six digits.
constexpr double kFlat = 1e-5;

/// Of a part that is taken as its hull, as a fraction of its volume: files have few digits.
constexpr double kMostOutside = 0.01;

void Append(const Mesh& part, Mesh& mesh) {
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), part.vertices.begin(), part.vertices.end());
  for (const Triangle& t : part.triangles)
    mesh.triangles.push_back({base + t[0], base + t[1], base + t[2]});
}

double VolumeOf(const Hull& hull) { return SignedVolume(SurfaceOf(hull)); }

/// The hull of the corners, with fewer of them as long as little volume is lost. Round hulls may
/// have more if there are few hulls.
std::optional<Hull> Limited(const std::vector<Vector3d>& corners, std::size_t hulls,
                            const DecomposeOptions& options) {
  constexpr double kEnough = 0.985;
  constexpr std::size_t kFew = 24;
  constexpr std::size_t kMostGrowth = 4;
  if (corners.size() <= std::min(kFew, options.vertices_per_hull)) return TryConvexHull(corners);
  QuickHull hull;
  const double enough = kEnough * hull.Volume(corners);
  hull.Volume(corners, options.vertices_per_hull * std::max<std::size_t>(kMostGrowth / hulls, 1),
              enough);
  std::vector<Vector3d> fewer;
  for (const std::uint32_t i : hull.Corners()) fewer.push_back(corners[i]);
  return TryConvexHull(fewer);
}

class Decomposer {
 public:
  Decomposer(const Mesh& mesh, const DecomposeOptions& options)
      : options_(options), flat_(0), search_(0) {
    Eigen::AlignedBox3d box;
    for (const Vector3d& vertex : mesh.vertices) box.extend(vertex);
    flat_ = kFlat * box.diagonal().norm();
    search_ = CutSearch(flat_);
    Begin(mesh, box);
  }

  std::vector<Hull> Hulls() {
    Split();
    Merge();
    std::vector<Hull> hulls;
    for (const Piece& piece : pieces_)
      if (std::optional<Hull> hull = Limited(piece.corners, pieces_.size(), options_))
        hulls.push_back(*std::move(hull));
    return hulls;
  }

 private:
  /// The parts of the mesh that are not connected, and where they overlap.
  void Begin(const Mesh& mesh, const Eigen::AlignedBox3d& box) {
    const std::vector<std::uint32_t> parts = ConnectedParts(mesh);
    UnionFind solids(1 + *std::max_element(parts.begin(), parts.end()));
    const Rays rays(box);
    std::vector<Rays::Crossing> crossings;
    rays.Cast(mesh, parts, crossings);
    Rays::Sort(crossings);
    std::vector<Excess> excesses;
    double excess_volume = 0;
    int winding = 0;
    for (std::size_t i = 0; i + 1 < crossings.size(); ++i) {
      const Rays::Crossing &from = crossings[i], &to = crossings[i + 1];
      winding += from.turns;
      if (from.ray != to.ray) continue;
      if (winding > 0) solids.Join(from.label, to.label);
      if (winding == 0 || winding == 1 || from.at == to.at) continue;
      const double area = rays.CellArea() * (winding > 0 ? winding - 1 : winding);
      excesses.push_back({rays.PointAt(from.ray, from.at), rays.PointAt(to.ray, to.at), area});
      excess_volume += std::abs(area) * (to.at - from.at);
    }
    Piece whole{mesh, std::vector<std::int32_t>(mesh.triangles.size(), kSurface), {}, 0, {}, 0};
    volume_ = SignedVolume(mesh);
    if (excess_volume > kNoExcess * volume_) whole.excesses = std::move(excesses);
    volume_ = VolumeOf(whole);
    std::vector<std::uint32_t> labels;
    for (const std::uint32_t part : parts) labels.push_back(solids.Root(part));
    Keep(Separated(whole, labels, options_.least_volume * volume_, options_.hulls));
  }

  void Keep(std::vector<Piece> pieces) {
    for (Piece& piece : pieces) {
      FindHull(piece, piece.mesh.vertices);
      pieces_.push_back(std::move(piece));
    }
  }

  double Defect() const {
    double defect = 0;
    for (const Piece& piece : pieces_) defect += piece.Defect();
    return defect;
  }

  /// Cuts the piece with the largest defect until the sum of all is admissible.
  void Split() {
    const double admissible = options_.error * volume_;
    const std::size_t most = kSurplus * options_.hulls;
    std::vector<char> is_done(pieces_.size(), false);
    while (pieces_.size() < most && Defect() > admissible) {
      std::size_t worst = pieces_.size();
      for (std::size_t i = 0; i < pieces_.size(); ++i)
        if (!is_done[i] &&
            (worst == pieces_.size() || pieces_[i].Defect() > pieces_[worst].Defect()))
          worst = i;
      if (worst == pieces_.size()) return;
      if (options_.progress) options_.progress(pieces_.size());
      const std::size_t left = most - pieces_.size();
      const double price = kPrice * Defect() / static_cast<double>(options_.hulls);
      const auto cut = search_.Find(pieces_[worst], left);
      std::vector<Piece> parts;
      if (cut)
        parts =
            Cut(pieces_[worst], cut->plane, cuts_++, flat_, options_.least_volume * volume_, left);
      if (parts.size() < 2) {
        is_done[worst] = true;
        continue;
      }
      for (Piece& part : parts) FindHull(part, part.mesh.vertices);
      // A plane may also have cut where nothing is gained, such as a second limb.
      JoinCheap(parts, 2, price);
      pieces_.erase(pieces_.begin() + static_cast<std::ptrdiff_t>(worst));
      is_done.erase(is_done.begin() + static_cast<std::ptrdiff_t>(worst));
      for (Piece& part : parts) pieces_.push_back(std::move(part));
      is_done.resize(pieces_.size(), false);
    }
  }

  /// What the hull of two pieces adds to those of each.
  double CostOf(const Piece& a, const Piece& b) {
    std::vector<Vector3d> points = a.corners;
    points.insert(points.end(), b.corners.begin(), b.corners.end());
    return hull_.Volume(points) - a.hull_volume - b.hull_volume;
  }

  /// Joins pieces as long as there are too many or the sum of the defects remains admissible.
  void Merge() {
    JoinCheap(pieces_, options_.hulls, std::numeric_limits<double>::infinity());
    // What a join adds may be in a third hull.
    const double spare = std::min(options_.error * volume_ - Defect(), kMostOverlap * volume_);
    JoinCheap(pieces_, 1, spare, spare);
  }

  /// Joins the two pieces whose common hull adds least, down to `least` pieces, as long as that
  /// costs at most `price`, and all joins together at most `sum`.
  void JoinCheap(std::vector<Piece>& pieces, std::size_t least, double price,
                 double sum = std::numeric_limits<double>::infinity()) {
    if (pieces.size() <= least) return;
    std::vector<std::vector<double>> costs(pieces.size());
    for (std::size_t i = 0; i < pieces.size(); ++i)
      for (std::size_t k = 0; k < i; ++k) costs[i].push_back(CostOf(pieces[i], pieces[k]));
    while (pieces.size() > least) {
      std::size_t first = 1, second = 0;
      for (std::size_t i = 1; i < pieces.size(); ++i)
        for (std::size_t k = 0; k < i; ++k)
          if (costs[i][k] < costs[first][second]) std::tie(first, second) = std::tie(i, k);
      const double cost = costs[first][second];
      if (cost > std::min(price, sum)) return;
      sum -= cost;
      Join(pieces[second], pieces[first]);
      const auto at = static_cast<std::ptrdiff_t>(first);
      pieces.erase(pieces.begin() + at);
      costs.erase(costs.begin() + at);
      for (std::size_t i = first; i < costs.size(); ++i) costs[i].erase(costs[i].begin() + at);
      for (std::size_t i = 0; i < pieces.size(); ++i)
        if (i != second)
          costs[std::max(i, second)][std::min(i, second)] = CostOf(pieces[i], pieces[second]);
    }
  }

  void Join(Piece& to, const Piece& from) {
    std::vector<Vector3d> points = to.corners;
    points.insert(points.end(), from.corners.begin(), from.corners.end());
    to = Joined(to, from);
    FindHull(to, points);
  }

  void FindHull(Piece& piece, const std::vector<Vector3d>& points) {
    piece.hull_volume = hull_.Volume(points);
    std::vector<Vector3d> corners;
    for (const std::uint32_t i : hull_.Corners()) corners.push_back(points[i]);
    piece.corners = std::move(corners);
  }

  static constexpr double kNoExcess = 1e-3;
  /// More pieces than hulls are made at first, as cuts that prove useless can be undone.
  static constexpr std::size_t kSurplus = 2;
  /// The defect that a cut must avoid, as a fraction of that per hull.
  static constexpr double kPrice = 0.5;
  /// Of the hulls, as a fraction of the volume of the mesh, by joins that are not necessary.
  static constexpr double kMostOverlap = 0.01;

  const DecomposeOptions& options_;
  double flat_, volume_ = 0;
  std::vector<Piece> pieces_;
  std::int32_t cuts_ = 0;
  CutSearch search_;
  QuickHull hull_;
};

}  // namespace

Decomposition Assessed(std::vector<Hull> hulls, const Mesh& mesh) {
  Mesh surfaces;
  for (const Hull& hull : hulls) Append(SurfaceOf(hull), surfaces);
  const OverlapVolume volume = OverlapVolumeOf(mesh, surfaces);
  return {std::move(hulls), std::abs(volume.second - volume.first) / volume.first,
          volume.IntersectionOverUnion(), SignedVolume(mesh) / volume.first - 1,
          volume.second_in_all / volume.second - 1};
}

Decomposition Decompose(const Mesh& mesh, std::string_view name, const DecomposeOptions& options) {
  CDB_CHECK(options.hulls >= 1 && options.vertices_per_hull >= 4 && options.error > 0);
  const double volume = SignedVolume(mesh);
  const Hull whole = ConvexHull(mesh, name);
  const bool is_convex = VolumeOf(whole) - volume <= 1e-4 * volume;
  const std::optional<Hull> limited = Limited(whole.vertices, 1, options);
  Decomposition one = Assessed({limited ? *limited : whole}, mesh);
  if (is_convex) return one;
  if (mesh.triangles.size() > options.most_triangles)
    throw library::SceneError(fmt::format(
        "{}: has {} triangles, and decomposing more than {} takes longer than a minute; "
        "simplify it, or use its convex hull",
        name, mesh.triangles.size(), options.most_triangles));
  std::vector<Hull> hulls = Decomposer(mesh, options).Hulls();
  if (hulls.empty()) return one;
  Decomposition several = Assessed(std::move(hulls), mesh);
  return several.iou > one.iou ? several : one;
}

Mesh JoinConvexParts(std::span<const Mesh> parts, std::string_view name, std::vector<Hull>& hulls) {
  Mesh mesh;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::string part = fmt::format("{}: part {} of {}", name, i + 1, parts.size());
    const Mesh closed = Watertight(parts[i], part);
    hulls.push_back(ConvexHull(closed, part));
    const double volume = SignedVolume(closed), outside = VolumeOf(hulls.back()) / volume - 1;
    if (outside > kMostOutside) {
      Eigen::AlignedBox3d box;
      for (const Vector3d& vertex : closed.vertices) box.extend(vertex);
      const Vector3d at = box.center();
      throw library::SceneError(
          fmt::format("{}, about ({:.4g}, {:.4g}, {:.4g}), is not convex: its convex hull has "
                      "{:.3g} % more volume",
                      part, at.x(), at.y(), at.z(), 100 * outside),
          "decompose the mesh instead: remove `parts: given`");
    }
    Append(closed, mesh);
  }
  return mesh;
}

std::string DecomposerVersion() {
  const DecomposeOptions options;
  return fmt::format("cdb {} ({} {} {} {}) {}", kAlgorithm, options.hulls, options.error,
                     options.vertices_per_hull, options.least_volume, ConvexHullVersion());
}

}  // namespace cdb::meshes
