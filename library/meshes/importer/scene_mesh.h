// One mesh of all meshes in a scene that assimp reads.
//
// Errors: SceneError with the cause and the remedy, without the name of the file. Lengths in m
// where the file or its format states a unit, else in the unit of the file. Threads: one.
// Sources: COLLADA 1.5, glTF 2.0, FBX SDK 2020 (FbxAxisSystem, FbxSystemUnit), 3MF core 1.3, AMF
// (ISO/ASTM 52915), X3D (ISO/IEC 19775).
#pragma once

#include <string>
#include <string_view>

namespace cdb::importer {

/// The mesh as binary PLY, whose comments name what was left out. `extension`: `.dae`.
std::string PlyOf(std::string bytes, std::string_view extension);

// Facts of a file that assimp does not tell.

/// The unit of a 3MF, AMF or X3D file, in m; 1 for others. Refuses a 3MF file that needs an
/// extension which changes its surface.
double UnitOf(std::string_view bytes, std::string_view extension);

/// Refuses a glTF file that needs files other than those of data that follow it, or an extension
/// that changes its meshes. Returns it with the data in their URIs.
std::string CheckedGltf(std::string bytes);

}  // namespace cdb::importer
