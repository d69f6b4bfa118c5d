// Meshes of files in the formats of other programs (COLLADA, glTF, FBX, 3MF and so on), by assimp.
//
// Files crash importers, so assimp runs in a separate process: the program `cdb-import`
// (library/meshes/importer/), which gets the bytes of the file and returns a mesh. It has limits of
// time and memory, an empty environment and no open file, and is confined (library/confinement.h).
// Its crash is an error of the file.
//
// Lengths in m where the file or its format states a unit, else in the unit of the file. y is up
// where the file states the upward axis. Errors: SceneError with the file, the cause and the
// remedy. Threads: any. Takes about 20 ms to start.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "library/meshes/mesh.h"

namespace cdb::meshes {

struct ImportLimits {
  std::uint64_t cpu_s = 10;
  std::uint64_t wall_s = 160;  ///< on a busy machine, a second of processor time takes many
  std::uint64_t memory_bytes = std::uint64_t{2} << 30;  ///< of address space
  std::uint64_t mesh_bytes = kMaxFileBytes;             ///< of the returned mesh
};

/// The limits for a file of `bytes`.
ImportLimits LimitsForImport(std::uint64_t bytes);

/// `cdb-import`, beside this program.
std::filesystem::path ImporterProgram();

/// The mesh of a file with these contents. Faces of all parts, transformed by their nodes; equal
/// vertices are not merged. `name` is that of the file; its extension selects the format.
Mesh ImportMesh(std::string_view bytes, std::string_view name,
                const std::filesystem::path& program = ImporterProgram());
/// The same with other limits.
Mesh ImportMesh(std::string_view bytes, std::string_view name, const std::filesystem::path& program,
                const ImportLimits& limits);

}  // namespace cdb::meshes
