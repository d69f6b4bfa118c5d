#include "library/deforming/mesh_sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "compiler/plan/input_file.h"
#include "library/scene_error.h"

namespace cdb::deforming {
namespace {

namespace fs = std::filesystem;
using library::SceneError;

/// The formats whose vertices keep their order; the others list the corners of each triangle.
constexpr std::string_view kFormats[] = {".ply", ".obj", ".off"};

void CheckFormat(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  if (std::ranges::find(kFormats, extension) == std::end(kFormats))
    throw SceneError(
        fmt::format("{}: the vertices of a format `{}` have no order from one frame to the next; "
                    "convert the frames to PLY, OBJ or OFF",
                    file.string(), extension));
}

/// Rejects a frame that is not the first one moved.
void CheckSame(const meshes::Mesh& first, const fs::path& first_file, const meshes::Mesh& frame,
               const fs::path& file) {
  const auto refuse = [&](const std::string& what) {
    throw SceneError(
        fmt::format("{}: {}; every frame needs the vertices and triangles of the first in the same "
                    "order: export the frames without remeshing, as triangles",
                    file.string(), what));
  };
  if (frame.vertices.size() != first.vertices.size())
    refuse(fmt::format("it has {} vertices, and {} has {}", frame.vertices.size(),
                       first_file.string(), first.vertices.size()));
  if (frame.triangles.size() != first.triangles.size())
    refuse(fmt::format("it has {} triangles, and {} has {}", frame.triangles.size(),
                       first_file.string(), first.triangles.size()));
  const auto [other, mine] = std::ranges::mismatch(first.triangles, frame.triangles);
  if (other == first.triangles.end()) return;
  refuse(fmt::format("its triangle {} is {} {} {}, and that of {} is {} {} {}",
                     mine - frame.triangles.begin(), (*mine)[0], (*mine)[1], (*mine)[2],
                     first_file.string(), (*other)[0], (*other)[1], (*other)[2]));
}

}  // namespace

bool MeshSequence::IsSingle() const {
  return std::ranges::all_of(frames, [](const std::vector<Eigen::Vector3d>& frame) {
    return std::ranges::all_of(
        frame, [](const Eigen::Vector3d& at) { return at.cast<float>().cast<double>() == at; });
  });
}

MeshSequence ReadSequence(std::span<const fs::path> files) {
  MeshSequence sequence;
  meshes::Mesh first;
  for (const fs::path& file : files) {
    CheckFormat(file);
    meshes::Mesh frame = meshes::ReadMesh(file);
    if (sequence.frames.empty()) {
      first = frame;
      sequence.triangles = std::move(frame.triangles);
    } else {
      CheckSame(first, files[0], frame, file);
    }
    sequence.frames.push_back(std::move(frame.vertices));
  }
  CheckSequence(sequence, files.empty() ? "the sequence" : files[0].string());
  return sequence;
}

void CheckSequence(const MeshSequence& sequence, std::string_view name) {
  const auto refuse = [&](const std::string& what) {
    throw SceneError(fmt::format("{}: {}", name, what));
  };
  if (sequence.frames.empty()) refuse("there is no frame; name at least one");
  if (sequence.triangles.empty()) refuse("there are no triangles; a point cloud does not collide");
  const std::size_t vertices = sequence.vertices();
  for (std::size_t i = 0; i < sequence.triangles.size(); ++i) {
    const auto [a, b, c] = sequence.triangles[i];
    if (std::max({a, b, c}) >= vertices)
      refuse(fmt::format("triangle {} has vertex {}, counted from 0, but there are {}", i,
                         std::max({a, b, c}), vertices));
    if (a == b || b == c || c == a)
      refuse(fmt::format("triangle {} has a vertex twice ({} {} {}); remove it from every frame", i,
                         a, b, c));
  }
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    const auto& frame = sequence.frames[i];
    if (frame.size() != vertices)
      refuse(
          fmt::format("frame {} has {} vertices, and frame 0 has {}", i, frame.size(), vertices));
    const auto bad =
        std::ranges::find_if(frame, [](const Eigen::Vector3d& at) { return !at.allFinite(); });
    if (bad != frame.end())
      refuse(
          fmt::format("vertex {} of frame {} is ({}, {}, {}), which is not finite; the "
                      "simulation failed there: use the frames before it",
                      bad - frame.begin(), i, bad->x(), bad->y(), bad->z()));
  }
}

std::string Sha256(const MeshSequence& sequence) {
  std::string bytes;
  const auto add = [&](const auto* from, std::size_t count) {
    bytes.append(reinterpret_cast<const char*>(from), count * sizeof *from);
  };
  const std::uint64_t sizes[] = {sequence.triangles.size(), sequence.vertices()};
  add(sizes, std::size(sizes));
  add(sequence.triangles.data(), sequence.triangles.size());
  for (const auto& frame : sequence.frames) add(frame.data(), frame.size());
  return plan::Sha256Hex(bytes);
}

}  // namespace cdb::deforming
