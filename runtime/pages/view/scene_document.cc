#include "runtime/pages/view/scene_document.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>
#include <vector>

#include "compiler/analysis/configurations.h"
#include "compiler/analysis/soft.h"
#include "library/objects/soft_form.h"

namespace cdb::view {
namespace {

using Json = nlohmann::ordered_json;

void Append(std::vector<double>& values, const Eigen::Vector3d& vector) {
  values.insert(values.end(), vector.begin(), vector.end());
}

std::string PackVectors(const std::vector<Eigen::Vector3f>& vectors) {
  std::vector<double> values;
  for (const Eigen::Vector3f& vector : vectors) Append(values, vector.cast<double>());
  return PackFloats(values);
}

Json MeshesOf(const Tessellation& tessellation) {
  Json meshes = Json::array();
  for (const TriangleMesh& mesh : tessellation.meshes()) {
    const std::vector<std::int32_t> indices(mesh.indices.begin(), mesh.indices.end());
    meshes.push_back({{"name", mesh.name},
                      {"positions", PackVectors(mesh.positions)},
                      {"normals", PackVectors(mesh.normals)},
                      {"indices", PackInts(indices)}});
  }
  return meshes;
}

void AddBodies(const SceneRecording& recording, Json& run) {
  Tessellation tessellation(recording.ObjectCount());
  std::vector<std::int32_t> groups, part_bodies, part_meshes;
  std::vector<double> masses, sides, places, radii;
  for (std::size_t i = 0; i < recording.ObjectCount(); ++i) {
    const layouts::ObjectState& object = recording.state.objects[i];
    groups.push_back(static_cast<std::int32_t>(object.group));
    masses.push_back(object.mass);
    Append(sides, object.solid.sides);
    const auto& compound = object.solid.compound;
    radii.push_back(object.solid.OuterRadius() +
                    (compound != nullptr ? compound->OriginToCentre().norm() : 0));
    if (analysis::IsSoft(recording.scene.groups[object.group])) continue;  // drawn by its nodes
    for (const Part& part : tessellation.PartsOf(object.solid)) {
      part_bodies.push_back(static_cast<std::int32_t>(i));
      part_meshes.push_back(static_cast<std::int32_t>(part.mesh));
      Append(places, part.scale);
      const Eigen::Quaterniond& q = part.rotation;
      places.insert(places.end(), {q.x(), q.y(), q.z(), q.w(), part.offset_y});
    }
  }
  run["meshes"] = MeshesOf(tessellation);
  run["bodies"] = {{"count", recording.ObjectCount()},
                   {"group", PackInts(groups)},
                   {"mass", PackFloats(masses)},
                   {"sides", PackFloats(sides)},
                   {"radius", PackFloats(radii)}};
  run["parts"] = {{"body", PackInts(part_bodies)},
                  {"mesh", PackInts(part_meshes)},
                  {"place", PackFloats(places)}};
}

void AddSoft(const SceneRecording& recording, Json& run) {
  if (!analysis::HasSoft(recording.scene)) return;
  Json bodies = Json::array();
  std::size_t first = 0;
  for (std::size_t i = 0; i < recording.ObjectCount(); ++i) {
    const plan::Group& group = recording.scene.groups[recording.state.objects[i].group];
    if (!analysis::IsSoft(group)) continue;
    const analysis::SoftMesh mesh = objects::SoftMeshOf(group.settings.Get("type"));
    std::vector<std::int32_t> triangles, links;
    for (const auto& triangle : mesh.triangles)
      triangles.insert(triangles.end(), triangle.begin(), triangle.end());
    if (mesh.triangles.empty())  // a rope
      for (const auto& link : mesh.links) links.insert(links.end(), link.begin(), link.end());
    bodies.push_back({{"body", i},
                      {"first", first},
                      {"count", mesh.NodeCount()},
                      {"triangles", PackInts(triangles)},
                      {"links", PackInts(links)}});
    first += mesh.NodeCount();
  }
  run["soft"] = {
      {"nodes", first}, {"position", PackFloats(recording.nodes)}, {"bodies", std::move(bodies)}};
}

void AddFrames(const SceneRecording& recording, Json& run) {
  std::vector<double> positions;
  std::vector<std::uint16_t> orientations;
  const std::vector<double>& poses = recording.poses;
  for (std::size_t i = 0; i < poses.size() / protocol::kPoseSize; ++i) {
    const double* pose = &poses[i * protocol::kPoseSize];
    positions.insert(positions.end(), pose, pose + 3);
    const auto words = PackQuaternion({pose[6], pose[3], pose[4], pose[5]}, recording.unmoved[i]);
    orientations.insert(orientations.end(), words.begin(), words.end());
  }
  run["frames"] = {{"count", recording.FrameCount()},
                   {"is_start", recording.cycles.empty()},
                   {"first", recording.cycles.empty() ? 0 : recording.cycles.front()},
                   {"every", recording.every},
                   {"position", PackFloats(positions)},
                   {"orientation", PackShorts(orientations)}};
}

Json ContactsOf(const SceneRecording& recording) {
  std::vector<std::int32_t> counts, bodies;
  std::vector<double> points, normals, distances;
  for (const auto& frame : recording.contacts) {
    counts.push_back(static_cast<std::int32_t>(frame.size()));
    for (const protocol::ContactRecord& contact : frame) {
      bodies.push_back(static_cast<std::int32_t>(contact.body_a));
      bodies.push_back(static_cast<std::int32_t>(contact.body_b));
      points.insert(points.end(), std::begin(contact.point), std::end(contact.point));
      normals.insert(normals.end(), std::begin(contact.normal), std::end(contact.normal));
      distances.push_back(contact.distance);
    }
  }
  return {{"count", PackInts(counts)},
          {"body", PackInts(bodies)},
          {"point", PackFloats(points)},
          {"normal", PackFloats(normals)},
          {"distance", PackFloats(distances)}};
}

Json SeriesOf(const std::vector<CycleSeries>& all) {
  Json list = Json::array();
  for (const CycleSeries& series : all)
    list.push_back({{"name", series.name},
                    {"unit", series.unit},
                    {"interval", series.interval_s},
                    {"values", PackFloats(series.values)}});
  return list;
}

Json RunOf(const SceneRecording& recording) {
  const plan::WorldSettings& world = recording.scene.world;
  const Eigen::Vector3d& acceleration = recording.state.acceleration;
  Json run = {{"file", recording.file},
              {"benchmark", recording.benchmark},
              {"title", recording.title},
              {"name", recording.name},
              {"is_run", recording.is_run},
              {"status", std::string(results::StatusName(recording.status))},
              {"verdict", std::string(protocol::VerdictName(recording.judgement.verdict))},
              {"criterion", recording.judgement.criterion},
              {"first_bad_cycle", recording.judgement.first_bad_cycle},
              {"unchecked", recording.unchecked},
              {"message", recording.message},
              {"timestep", world.Real("timestep")},
              {"warmup", world.Count("warmup")},
              {"cycles", recording.n_cycles},
              {"side", world.Real("world.side")},
              {"walls", std::string(world.WordOr("world.walls"))},
              {"detector", std::string(world.WordOr("detector"))},
              {"acceleration", {acceleration.x(), acceleration.y(), acceleration.z()}},
              {"record", world.Words("record")},
              {"notices", recording.notices}};
  if (analysis::HasConfigurations(recording.scene)) run["has_configurations"] = true;
  run["groups"] = Json::array();
  for (const plan::Group& group : recording.scene.groups)
    run["groups"].push_back({{"name", group.name}, {"quantity", group.settings.Count("quantity")}});
  AddBodies(recording, run);
  AddFrames(recording, run);
  AddSoft(recording, run);
  run["boxes"] = recording.boxes.empty() ? Json() : Json(PackFloats(recording.boxes));
  run["contacts"] = recording.has_contacts ? ContactsOf(recording) : Json();
  run["durations"] = SeriesOf(recording.durations);
  run["series"] = SeriesOf(recording.series);
  return run;
}

}  // namespace

std::string SceneDocument(const std::string& title, std::span<const SceneRecording> recordings) {
  Json document = {{"title", title}, {"runs", Json::array()}};
  for (const SceneRecording& recording : recordings) document["runs"].push_back(RunOf(recording));
  return document.dump(-1, ' ', false, Json::error_handler_t::replace);
}

namespace {

static_assert(std::endian::native == std::endian::little);

template <typename Value>
std::string PackValues(std::span<const Value> values) {
  return Base64(std::as_bytes(values));
}

}  // namespace

std::string Base64(std::span<const std::byte> bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < n ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k) text += k <= n ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string PackFloats(std::span<const double> values) {
  std::vector<float> floats;
  floats.reserve(values.size());
  for (const double value : values) floats.push_back(static_cast<float>(value));
  return PackValues(std::span<const float>(floats));
}
std::string PackInts(std::span<const std::int32_t> values) { return PackValues(values); }
std::string PackShorts(std::span<const std::uint16_t> values) { return PackValues(values); }

std::array<std::uint16_t, 3> PackQuaternion(const Eigen::Quaterniond& q, bool flag) {
  Eigen::Vector4d c = q.coeffs();  // x y z w
  if (!c.allFinite() || !(c.norm() > 0)) c = {0, 0, 0, 1};
  c.normalize();
  int largest = 0;
  c.cwiseAbs().maxCoeff(&largest);
  if (c[largest] < 0) c = -c;  // the same rotation
  std::array<std::uint16_t, 3> words{};
  std::size_t word = 0;
  for (int i = 0; i < 4; ++i) {
    if (i == largest) continue;
    const double unit = std::clamp(c[i] * std::numbers::sqrt2, -1.0, 1.0);
    words[word++] = static_cast<std::uint16_t>(std::lround((unit + 1) / 2 * 32767));
  }
  const auto top = [](std::uint16_t value, bool bit) {
    return static_cast<std::uint16_t>(value | (bit ? 0x8000 : 0));
  };
  words[0] = top(words[0], (largest & 2) != 0);
  words[1] = top(words[1], (largest & 1) != 0);
  words[2] = top(words[2], flag);
  return words;
}

namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using objects::Shape;
using shapes::Profile;
using shapes::ProfilePoint;

void AddFace(TriangleMesh& mesh, const std::vector<Vector3d>& corners) {
  const Vector3d across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  if (!(across.norm() > 1e-12)) return;  // a degenerate triangle has no normal
  const Vector3d normal = across.normalized();
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Vector3d& corner : corners) {
    mesh.positions.push_back(corner.cast<float>());
    mesh.normals.push_back(normal.cast<float>());
  }
  for (std::uint32_t i = 2; i < corners.size(); ++i)
    mesh.indices.insert(mesh.indices.end(), {first, first + i - 1, first + i});
}

/// Rotates the profile about y.
void AddSurface(TriangleMesh& mesh, const Profile& profile, int segments) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto n = static_cast<std::uint32_t>(segments);
  for (const ProfilePoint& point : profile)
    for (std::uint32_t i = 0; i <= n; ++i) {
      const double angle = 2 * std::numbers::pi * (i % n) / n;
      const double c = std::cos(angle), s = std::sin(angle);
      mesh.positions.push_back(Vector3d(point.x * c, point.y, point.x * s).cast<float>());
      mesh.normals.push_back(
          Vector3d(point.normal_x * c, point.normal_y, point.normal_x * s).cast<float>());
    }
  for (std::uint32_t row = 0; row + 1 < profile.size(); ++row)
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = first + row * (n + 1) + i, b = a + n + 1;
      if (profile[row].x > 0) mesh.indices.insert(mesh.indices.end(), {a, b, a + 1});
      if (profile[row + 1].x > 0) mesh.indices.insert(mesh.indices.end(), {a + 1, b, b + 1});
    }
}

TriangleMesh Turned(std::string name, const std::vector<Profile>& profiles, int segments) {
  TriangleMesh mesh{std::move(name), {}, {}, {}};
  for (const Profile& profile : profiles) AddSurface(mesh, profile, segments);
  return mesh;
}

/// The triangles of a height field, or of every few of its rows and columns, if it has many.
TriangleMesh MeshOfHeights(const objects::ConvexDecomposition& form) {
  const terrain::HeightGrid& grid = form.heights->grid();
  const auto lines = [](std::size_t points) {
    std::vector<std::size_t> at;
    for (std::size_t i = 0; i < points - 1; i += HeightStep(points)) at.push_back(i);
    at.push_back(points - 1);
    return at;
  };
  const auto columns = lines(grid.columns), rows = lines(grid.rows);
  TriangleMesh mesh{form.name, {}, {}, {}};
  for (std::size_t row = 0; row + 1 < rows.size(); ++row)
    for (std::size_t column = 0; column + 1 < columns.size(); ++column) {
      const auto at = [&](std::size_t right, std::size_t below) -> Vector3d {
        return form.heights->Point(columns[column + right], rows[row + below]) - form.origin;
      };
      AddFace(mesh, {at(0, 0), at(0, 1), at(1, 0)});
      AddFace(mesh, {at(1, 0), at(0, 1), at(1, 1)});
      AddFace(mesh, {at(1, 0), at(0, 1), at(0, 0)});
      AddFace(mesh, {at(1, 1), at(0, 1), at(1, 0)});
    }
  return mesh;
}

/// All convex pieces, or the triangles of a surface from both sides, in the axes of the model and
/// about its origin, to which recorded poses refer.
TriangleMesh CompoundMesh(const objects::ConvexDecomposition& form) {
  if (form.heights) return MeshOfHeights(form);
  TriangleMesh mesh{form.name, {}, {}, {}};
  for (const objects::ConvexPiece& piece : form.pieces)
    for (const meshes::Triangle& face : piece.faces) {
      std::vector<Vector3d> corners;
      for (const auto corner : face)
        corners.push_back(piece.vertices[static_cast<std::size_t>(corner)] + piece.centre -
                          form.origin);
      AddFace(mesh, corners);
      if (!form.IsSurface()) continue;
      std::ranges::reverse(corners);
      AddFace(mesh, corners);
    }
  return mesh;
}

/// With sides of 1: in each octant the product of two curves.
TriangleMesh SuperellipsoidMesh(double e1, double e2, int steps) {
  using shapes::Superellipsoid;
  TriangleMesh mesh{std::string(Superellipsoid::kType.name()), {}, {}, {}};
  const Profile along = Superellipsoid::Quadrant(e1, steps),
                around = Superellipsoid::Quadrant(e2, steps);
  const auto columns = static_cast<std::uint32_t>(around.size());
  for (unsigned octant = 0; octant < 8; ++octant) {
    const Vector3d sign((octant & 1) != 0 ? -1 : 1, (octant & 2) != 0 ? -1 : 1,
                        (octant & 4) != 0 ? -1 : 1);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const ProfilePoint& row : along)
      for (const ProfilePoint& column : around) {
        const Vector3d at(row.x * column.x, row.y, row.x * column.y);
        const Vector3d out(row.normal_x * column.normal_x, row.normal_y,
                           row.normal_x * column.normal_y);
        mesh.positions.push_back((0.5 * sign.cwiseProduct(at)).cast<float>());
        mesh.normals.push_back(sign.cwiseProduct(out).normalized().cast<float>());
      }
    const bool is_mirrored = sign.prod() < 0;
    for (std::uint32_t row = 0; row + 1 < along.size(); ++row)
      for (std::uint32_t column = 0; column + 1 < columns; ++column) {
        const std::uint32_t a = first + row * columns + column, b = a + columns;
        for (std::array<std::uint32_t, 3> face :
             {std::array{a, b, a + 1}, std::array{a + 1, b, b + 1}}) {
          if (is_mirrored) std::swap(face[1], face[2]);
          mesh.indices.insert(mesh.indices.end(), face.begin(), face.end());
        }
      }
  }
  return mesh;
}

constexpr int kFineSegments = 36;

/// Their addresses are the keys of meshes that do not belong to a form.
constexpr char kShapeKeys[objects::kClosedShapes.size()] = {}, kTubeKey[1] = {}, kTopKey[1] = {},
               kBottomKey[1] = {};

}  // namespace

Tessellation::Tessellation(std::size_t bodies)
    : segments_(bodies > 2000  ? 12
                : bodies > 300 ? 20
                               : kFineSegments) {}

template <typename Make>
std::size_t Tessellation::MeshOf(const void* key, Make make) {
  const auto [found, is_new] = found_.emplace(key, meshes_.size());
  if (is_new) meshes_.push_back(make());
  return found->second;
}

std::vector<Part> Tessellation::CapsuleParts(const objects::Solid& solid) {
  constexpr double kRight = std::numbers::pi / 2;
  const double straight = shapes::Capsule::StraightHalf(solid.sides);
  const Vector3d caps(solid.sides.x(), solid.sides.y() - 2 * straight, solid.sides.z());
  const Vector3d tube(solid.sides.x(), 2 * straight, solid.sides.z());
  const auto none = Eigen::Quaterniond::Identity();
  const auto cap = [&](const char* name, double from, double to) {
    return Turned(name, {shapes::Ellipsoid::Arc(from, to, segments_)}, segments_);
  };
  return {{MeshOf(kTopKey, [&] { return cap("capsule top", 0, kRight); }), caps, none, straight},
          {MeshOf(kBottomKey, [&] { return cap("capsule bottom", -kRight, 0); }), caps, none,
           -straight},
          {MeshOf(kTubeKey,
                  [&] { return Turned("capsule tube", {shapes::Cylinder::Side()}, segments_); }),
           tube, none, 0}};
}

Part Tessellation::CompoundPart(const objects::Solid& solid) {
  const objects::ConvexDecomposition& form = solid.compound->form();
  return {MeshOf(&form, [&] { return CompoundMesh(form); }), solid.compound->sides(),
          Eigen::Quaterniond::Identity(), 0};
}

Part Tessellation::SuperellipsoidPart(const objects::Solid& solid) {
  // Each pair of exponents has a mesh, which many bodies would make a page too large.
  const bool rounds = segments_ < kFineSegments;
  const auto drawn = [&](double e) { return rounds ? std::max(0.1, std::round(10 * e) / 10) : e; };
  const double e1 = drawn(solid.exponents.x()), e2 = drawn(solid.exponents.y());
  const auto [found, is_new] = superellipsoids_.emplace(std::pair(e1, e2), meshes_.size());
  if (is_new) meshes_.push_back(SuperellipsoidMesh(e1, e2, std::max(3, segments_ * 2 / 9)));
  return {found->second, solid.sides, Eigen::Quaterniond::Identity(), 0};
}

std::vector<Part> Tessellation::PartsOf(const objects::Solid& solid) {
  if (solid.compound) return {CompoundPart(solid)};
  if (solid.shape == Shape::kSuperellipsoid) return {SuperellipsoidPart(solid)};
  if (solid.shape == Shape::kCapsule && shapes::Capsule::StraightHalf(solid.sides) > 0)
    return CapsuleParts(solid);
  // A capsule that is not higher than wide is an ellipsoid.
  const Shape shape = solid.shape == Shape::kCapsule ? Shape::kEllipsoid : solid.shape;
  const std::size_t mesh = MeshOf(&kShapeKeys[static_cast<std::size_t>(shape)], [&] {
    return objects::Visit(shape, [&](auto form) {
      const std::string name(form.kType.name());
      if constexpr (requires { form.Profiles(segments_); })
        return Turned(name, form.Profiles(segments_), segments_);
      TriangleMesh mesh_of_faces{name, {}, {}, {}};
      if constexpr (requires { form.Faces(); })
        for (const shapes::FlatFace& face : form.Faces()) AddFace(mesh_of_faces, face);
      return mesh_of_faces;
    });
  });
  return {{mesh, solid.sides, Eigen::Quaterniond::Identity(), 0}};
}

}  // namespace cdb::view
