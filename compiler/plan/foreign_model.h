// Files that hold models, heights or voxels, but not in a format that cdb reads: what they are, and
// the way out.
//
// Errors: none. Threads: any.
#pragma once

#include <string>
#include <string_view>

namespace cdb::plan {

/// The extensions of what cdb reads.
inline constexpr std::string_view kModelFormats[] = {".obj", ".ply", ".stl", ".off"};
inline constexpr std::string_view kHeightFormats[] = {".csv", ".asc",  ".png",
                                                      ".tif", ".tiff", ".hgt"};
inline constexpr std::string_view kVoxelFormats[] = {".raw", ".binvox", ".npy", ".ply", ".pcd"};

struct ForeignModel {
  std::string kind;    ///< `a COLLADA scene`; empty if the file is none that is known
  std::string remedy;  ///< one sentence, without a full stop
};

/// By the first bytes, or else by the extension of the name. A file of a format that cdb reads is
/// foreign if its extension is that of another.
ForeignModel ForeignModelOf(std::string_view name, std::string_view bytes);
/// The same for files of heights.
ForeignModel ForeignHeightsOf(std::string_view name, std::string_view bytes);

/// The same for grids of cells and point clouds.
ForeignModel ForeignVoxelsOf(std::string_view name, std::string_view bytes);

/// The library by which this build reads files with this extension, such as `.dae`, with its
/// version: library/meshes/import.h. Empty if there is none.
std::string_view ImporterOf(std::string_view extension);

}  // namespace cdb::plan
