#include "library/objects/soft_form.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <limits>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/analysis/model.h"
#include "compiler/plan/foreign_model.h"
#include "compiler/plan/input_file.h"
#include "compiler/schema/parametrised_words.h"
#include "library/content_cache.h"
#include "library/meshes/overlap_volume.h"
#include "library/meshes/topology.h"
#include "library/objects/solid_factory.h"
#include "library/scene_error.h"
#include "library/tetrahedra/stuffing.h"

namespace cdb::objects {
namespace {

using Eigen::Vector3d;

constexpr std::string_view kSoftKind = "tetrahedra";
/// To be incremented with changes that affect a form: reading of files, stuffing, and the storage.
constexpr int kSoftVersion = 1;
/// A larger volume of either outside the other is refused, unless the scenario accepts it.
constexpr double kLargestError = 0.1;
/// In cells: a node is at a side if it is closer to the outermost node.
constexpr double kSideDepth = 0.25;
/// Forms that are kept in memory.
constexpr std::size_t kKeptForms = 8;

/// The point of a triangle that is closest to `p`: Ericson, Real-Time Collision Detection, 5.1.5.
Vector3d ClosestOnTriangle(const Vector3d& p, const Vector3d& a, const Vector3d& b,
                           const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const Vector3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / (d4 - d3 + d5 - d6) * (c - b);
  const double sum = va + vb + vc;
  return a + vb / sum * ab + vc / sum * ac;
}

/// The largest distance of a vertex of the mesh from the surface.
double FarthestVertex(const meshes::Mesh& mesh, const meshes::Mesh& surface, double cell) {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const meshes::Triangle& triangle : surface.triangles) {
    Eigen::AlignedBox3d& box = boxes.emplace_back();
    for (const Vector3d& corner : meshes::CornersOf(surface, triangle)) box.extend(corner);
  }
  const BoxTree tree(std::move(boxes));
  double farthest = 0;
  for (const Vector3d& vertex : mesh.vertices) {
    double nearest = std::numeric_limits<double>::infinity();
    for (double reach = cell / 2; !(nearest <= reach); reach *= 2) {
      const Vector3d around = Vector3d::Constant(reach);
      tree.AnyOf(Eigen::AlignedBox3d(vertex - around, vertex + around), [&](std::size_t i) {
        const auto [a, b, c] = meshes::CornersOf(surface, surface.triangles[i]);
        nearest = std::min(nearest, (vertex - ClosestOnTriangle(vertex, a, b, c)).norm());
        return false;
      });
    }
    farthest = std::max(farthest, nearest);
  }
  return farthest;
}

SoftForm MakeForm(const meshes::Mesh& mesh, std::size_t cells, const std::string& file) {
  const tetrahedra::Tetrahedra made = tetrahedra::Stuff(mesh, cells, file);
  Eigen::AlignedBox3d box;
  for (const Vector3d& vertex : mesh.vertices) box.extend(vertex);
  SoftForm form;
  for (const Vector3d& node : made.nodes)
    form.mesh.places.emplace_back((node - box.min()).cwiseQuotient(box.sizes()));
  form.mesh.tetrahedra = made.corners;
  form.mesh.side_depth = Vector3d::Constant(kSideDepth * made.cell).cwiseQuotient(box.sizes());
  form.native_side = box.sizes().maxCoeff();
  form.proportions = box.sizes() / form.native_side;
  analysis::AddLinksAndTriangles(form.mesh);
  meshes::Mesh surface;
  surface.vertices = made.nodes;
  surface.triangles = form.mesh.triangles;
  const meshes::OverlapVolume volume = meshes::OverlapVolumeOf(surface, mesh);
  form.volume_ratio = volume.first / volume.second;
  form.error = (volume.first + volume.second - 2 * volume.common) / volume.second;
  form.distance = FarthestVertex(mesh, surface, made.cell) / made.cell;
  const tetrahedra::DihedralAngles angles = tetrahedra::DihedralAnglesOf(made);
  form.least_angle = angles.least;
  form.most_angle = angles.most;
  form.left_out = mesh.left_out;
  return form;
}

/// Visits everything in a form but what follows from its tetrahedra.
void Visit(auto& archive, SoftForm& form) {
  const auto vector = [&](Vector3d& v) {
    for (double& x : v) archive.Real(x);
  };
  vector(form.mesh.side_depth);
  vector(form.proportions);
  for (double* real : {&form.native_side, &form.volume_ratio, &form.error, &form.distance,
                       &form.least_angle, &form.most_angle})
    archive.Real(*real);
  archive.Size(form.mesh.places);
  for (Vector3d& place : form.mesh.places) vector(place);
  archive.Size(form.mesh.tetrahedra);
  for (auto& corners : form.mesh.tetrahedra)
    for (std::uint32_t& corner : corners) archive.Index(corner);
  archive.Size(form.left_out);
  for (char& c : form.left_out) archive.Character(c);
}

std::optional<SoftForm> FindForm(const std::string& key) {
  const auto bytes = library::FindCached(library::CacheFolder(), kSoftKind, key);
  if (!bytes) return std::nullopt;
  library::ByteReader reader(*bytes);
  SoftForm form;
  Visit(reader, form);
  const bool is_whole = reader.IsDone() && !form.mesh.tetrahedra.empty() &&
                        std::ranges::all_of(form.mesh.tetrahedra, [&](const auto& corners) {
                          return *std::ranges::max_element(corners) < form.mesh.places.size();
                        });
  if (!is_whole) return std::nullopt;
  analysis::AddLinksAndTriangles(form.mesh);
  return form;
}

/// The form without the unit and the checks of a call.
std::shared_ptr<const SoftForm> FormOnce(const std::string& bytes, const std::string& sha256,
                                         const std::filesystem::path& file, std::size_t cells) {
  const std::string extension = file.extension().string();
  const std::string key = library::CacheKeyOf(fmt::format(
      "soft {} {} {} {} {}", kSoftVersion, extension, plan::ImporterOf(extension), sha256, cells));
  static std::mutex mutex;
  static std::deque<std::pair<std::string, std::shared_ptr<const SoftForm>>> kept;
  const std::lock_guard lock(mutex);
  const auto known = std::ranges::find(kept, key, [](const auto& entry) { return entry.first; });
  if (known != kept.end()) return known->second;
  std::optional<SoftForm> form = FindForm(key);
  if (!form) {
    const meshes::Mesh read = meshes::ParseMesh(bytes, file.string());
    form = MakeForm(meshes::Watertight(read, file.string()), cells, file.string());
    form->left_out = read.left_out;
    library::ByteWriter writer;
    Visit(writer, *form);
    library::StoreCached(library::CacheFolder(), kSoftKind, key, writer.Take());
  }
  kept.emplace_back(key, std::make_shared<const SoftForm>(*std::move(form)));
  if (kept.size() > kKeptForms) kept.pop_front();
  return kept.back().second;
}

void CheckError(const SoftForm& form, const schema::Call& type, const std::string& file,
                std::size_t cells) {
  const schema::Number* given = schema::AsNumber(schema::ArgumentOf(type, "error"));
  if (form.error <= (given != nullptr ? given->AsReal() : kLargestError)) return;
  const auto arguments = schema::FindParametrisedWord(type.name)->arguments;
  const double most = std::ranges::find(arguments, "cells", &schema::Parameter::name)->domain.max;
  throw library::SceneError(
      fmt::format("{}: at {} cells, the tetrahedra differ from the mesh by {:.3g} % of its volume: "
                  "features smaller than a cell are lost",
                  file, cells, 100 * form.error),
      fmt::format("{}accept it: `error: {:.2g}`",
                  static_cast<double>(2 * cells) <= most
                      ? fmt::format("use more cells, such as `cells: {}`, or ", 2 * cells)
                      : "",
                  std::ceil(100 * form.error) / 100));
}

}  // namespace

Vector3d SoftForm::SidesOf(double size, const Vector3d& aspect) const {
  analysis::ModelFacts facts;
  facts.sides = native_side * proportions;
  return facts.SidesOf(size, aspect);
}

std::shared_ptr<const SoftForm> SoftFormOf(const schema::Call& type) {
  const std::string& file = std::get<schema::Text>(schema::ArgumentOf(type, "file")).text;
  const auto cells = static_cast<std::size_t>(
      std::get<schema::Number>(schema::ArgumentOf(type, "cells")).AsCount());
  const std::string bytes = meshes::ReadMeshFile(file);
  const std::string sha256 = plan::Sha256Hex(bytes);
  const auto* planned = std::get_if<schema::Text>(&schema::ArgumentOf(type, "sha256"));
  if (planned != nullptr && sha256 != planned->text)
    throw library::SceneError(
        fmt::format("{}: it differs from the file that the plan was made with; plan again", file));
  std::shared_ptr<const SoftForm> form = FormOnce(bytes, sha256, file, cells);
  CheckError(*form, type, file, cells);
  const schema::Number* nodes = schema::AsNumber(schema::ArgumentOf(type, "nodes"));
  if (nodes != nullptr && nodes->AsCount() != form->mesh.NodeCount())
    throw library::SceneError(
        fmt::format("{}: at {} cells, its tetrahedra have {} nodes, and the plan states {}", file,
                    cells, form->mesh.NodeCount(), nodes->AsCount()),
        "plan again with this version of cdb");
  if (const double unit = MetresOfFile(type); unit != 1) {
    auto scaled = std::make_shared<SoftForm>(*form);
    scaled->native_side *= unit;
    form = std::move(scaled);
  }
  return form;
}

std::string TextOf(const SoftForm& form) {
  return fmt::format(
      "{} nodes, {} tetrahedra, angles of {:.0f} to {:.0f} degrees between their faces at the "
      "proportions of the file, {:.3g} % of the volume, vertices of the mesh up to {:.2g} cells "
      "from the surface{}{}",
      form.mesh.NodeCount(), form.mesh.tetrahedra.size(), form.least_angle, form.most_angle,
      100 * form.volume_ratio, form.distance,
      form.left_out.empty() ? "" : ", left out: ", form.left_out);
}

analysis::SoftMesh SoftMeshOf(const schema::Value& type) {
  return analysis::IsOfFile(type) ? SoftFormOf(*schema::AsCall(type))->mesh
                                  : analysis::MeshOf(type);
}

}  // namespace cdb::objects
