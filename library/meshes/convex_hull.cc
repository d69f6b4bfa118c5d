#include "library/meshes/convex_hull.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include "dsl/text/check.h"
#include "library/scene_error.h"

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace cdb::meshes {
namespace {

using Eigen::Vector3d;

/// A convex hull of points, by their indices.
struct Faces {
  std::vector<std::uint32_t> corners;  ///< ascending
  std::vector<Triangle> triangles;
};

/// The corners of a face in order, or null. Qhull leaves its functions by longjmp, or by exit if
/// nobody catches it; no object here has a destructor that would be skipped.
setT* CornersOf(qhT* qh, facetT* facet) {
  if (setjmp(qh->errexit) != 0) {
    qh->NOerrexit = True;
    return nullptr;
  }
  qh->NOerrexit = False;
  setT* const corners = qh_facet3vertex(qh, facet);
  qh->NOerrexit = True;
  return corners;
}

/// One run of Qhull. Its report goes to a stream, which is captured.
class Qhull {
 public:
  Qhull() : errors_(open_memstream(&text_, &size_)) {
    CDB_CHECK(errors_ != nullptr);
    qh_zero(&qh_, errors_);
  }
  ~Qhull() {
    qh_freeqhull(&qh_, !qh_ALL);
    int long_left = 0, bytes_left = 0;
    qh_memfreeshort(&qh_, &long_left, &bytes_left);
    std::fclose(errors_);
    std::free(text_);
  }
  Qhull(const Qhull&) = delete;
  Qhull& operator=(const Qhull&) = delete;

  /// Nullopt for flat points.
  std::optional<Faces> Run(std::vector<coordT>& coordinates) {
    char command[] = "qhull";
    const int status = qh_new_qhull(&qh_, 3, static_cast<int>(coordinates.size() / 3),
                                    coordinates.data(), False, command, nullptr, errors_);
    // For Qhull, a box without depth is invalid input, and other flat sets are singular.
    if (status == qh_ERRsingular || status == qh_ERRinput) return std::nullopt;
    if (status != qh_ERRnone) Fail();
    return Collect();
  }

 private:
  [[noreturn]] void Fail() {
    std::fflush(errors_);
    throw library::SceneError(
        fmt::format("Qhull cannot make a convex hull: {}", std::string_view(text_, size_)));
  }

  Faces Collect() {
    Faces faces;
    qhT* const qh = &qh_;  // the name that Qhull's macros use
    facetT* facet;
    FORALLfacets {
      // In order round the face, clockwise from outside. There may be more than three if Qhull
      // merged faces.
      setT* round = CornersOf(qh, facet);
      if (round == nullptr) Fail();
      std::vector<std::uint32_t> corners;
      vertexT *vertex, **vertexp;
      FOREACHvertex_(round) {
        corners.push_back(static_cast<std::uint32_t>(qh_pointid(qh, vertex->point)));
      }
      qh_settempfree(qh, &round);
      for (std::size_t i = 2; i < corners.size(); ++i)
        faces.triangles.push_back({corners[0], corners[i], corners[i - 1]});
      faces.corners.insert(faces.corners.end(), corners.begin(), corners.end());
    }
    std::sort(faces.corners.begin(), faces.corners.end());
    faces.corners.erase(std::unique(faces.corners.begin(), faces.corners.end()),
                        faces.corners.end());
    return faces;
  }

  char* text_ = nullptr;
  std::size_t size_ = 0;
  FILE* errors_;
  qhT qh_;
};

std::optional<Faces> FacesOf(std::span<const Vector3d> points) {
  if (points.size() < 4) return std::nullopt;
  // Qhull's tolerances grow with the coordinates, so these are relative to the middle, scaled to a
  // maximum of 1.
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : points) box.extend(p);
  const double unit = box.sizes().maxCoeff() / 2;
  if (!(unit > 0)) return std::nullopt;
  std::vector<coordT> coordinates;
  coordinates.reserve(3 * points.size());
  for (const Vector3d& p : points)
    for (const double x : Vector3d((p - box.center()) / unit)) coordinates.push_back(x);
  // On the heap, as a qhT takes several kilobytes.
  return std::make_unique<Qhull>()->Run(coordinates);
}

/// Four points that are far apart; fewer if all points are flat.
std::vector<std::uint32_t> LargeTetrahedron(std::span<const Vector3d> points) {
  std::vector<std::uint32_t> corners;
  const auto add_farthest = [&](const auto& distance) {
    std::uint32_t farthest = 0;
    double most = 0;
    for (std::uint32_t i = 0; i < points.size(); ++i)
      if (const double d = distance(points[i]); d > most) {
        most = d;
        farthest = i;
      }
    if (most > 0) corners.push_back(farthest);
    return most > 0;
  };
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& p : points) middle += p / static_cast<double>(points.size());
  const auto at = [&](std::size_t i) { return points[corners[i]]; };
  if (add_farthest([&](const Vector3d& p) { return (p - middle).norm(); }) &&
      add_farthest([&](const Vector3d& p) { return (p - at(0)).norm(); }) &&
      add_farthest([&](const Vector3d& p) { return (p - at(0)).cross(at(1) - at(0)).norm(); }))
    add_farthest([&](const Vector3d& p) {
      return std::abs((p - at(0)).dot((at(1) - at(0)).cross(at(2) - at(0))));
    });
  return corners;
}

}  // namespace

std::optional<Hull> TryConvexHull(std::span<const Vector3d> points) {
  const std::optional<Faces> faces = FacesOf(points);
  if (!faces) return std::nullopt;
  Hull hull;
  for (const std::uint32_t corner : faces->corners) hull.vertices.push_back(points[corner]);
  return hull;
}

namespace {

/// Without those of no face, unless there are no faces.
std::vector<Vector3d> UsedVertices(const Mesh& mesh) {
  if (mesh.triangles.empty()) return mesh.vertices;
  std::vector<bool> is_used(mesh.vertices.size(), false);
  for (const Triangle& triangle : mesh.triangles)
    for (const std::uint32_t vertex : triangle) is_used[vertex] = true;
  std::vector<Vector3d> used;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (is_used[i]) used.push_back(mesh.vertices[i]);
  return used;
}

}  // namespace

Hull ConvexHull(const Mesh& mesh, std::string_view name) {
  const std::vector<Vector3d> used = UsedVertices(mesh);
  std::optional<Hull> hull = TryConvexHull(used);
  if (!hull)
    throw library::SceneError(
        fmt::format("{}: is flat, so its convex hull has no volume; a solid needs one{}", name,
                    mesh.triangles.empty() ? "" : "; surface takes it as it is"));
  return *std::move(hull);
}

Mesh SurfaceOf(const Hull& hull) {
  const std::optional<Faces> faces = FacesOf(hull.vertices);
  CDB_CHECK(faces.has_value());
  return {hull.vertices, faces->triangles};
}

std::string_view ConvexHullVersion() { return qh_version; }

Hull WithFewerVertices(const Hull& hull, std::size_t count) {
  CDB_CHECK(count >= 4);
  if (hull.vertices.size() <= count) return hull;
  std::vector<std::uint32_t> chosen = LargeTetrahedron(hull.vertices);
  if (chosen.size() < 4) return hull;
  while (chosen.size() < count) {
    std::vector<Vector3d> points;
    for (const std::uint32_t i : chosen) points.push_back(hull.vertices[i]);
    const std::optional<Faces> faces = FacesOf(points);
    if (!faces) return hull;
    double most = 0;
    std::uint32_t farthest = 0;
    std::vector<std::pair<Vector3d, double>> planes;
    for (const Triangle& t : faces->triangles) {
      const Vector3d normal =
          (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).normalized();
      planes.emplace_back(normal, normal.dot(points[t[0]]));
    }
    for (std::uint32_t i = 0; i < hull.vertices.size(); ++i) {
      double outside = 0;
      for (const auto& [normal, offset] : planes)
        outside = std::max(outside, normal.dot(hull.vertices[i]) - offset);
      if (outside > most && std::find(chosen.begin(), chosen.end(), i) == chosen.end()) {
        most = outside;
        farthest = i;
      }
    }
    if (!(most > 0)) break;
    chosen.push_back(farthest);
  }
  std::sort(chosen.begin(), chosen.end());
  Hull fewer;
  for (const std::uint32_t i : chosen) fewer.vertices.push_back(hull.vertices[i]);
  return fewer;
}

}  // namespace cdb::meshes
