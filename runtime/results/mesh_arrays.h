// Deforming meshes in HDF5: `vertices(frame, vertex, 3)` and `faces(face, 3)`, as a few lines of
// Python write them.
#pragma once

#include <filesystem>

#include "library/deforming/mesh_sequence.h"

namespace cdb::results {

/// Reads the sequence from a file that any program may have written, and checks it. Indices count
/// from 0. Throws StoreError, with the file, the cause and the remedy.
deforming::MeshSequence ReadMeshArrays(const std::filesystem::path& file);

}  // namespace cdb::results
