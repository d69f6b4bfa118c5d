#include "compiler/plan/foreign_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <span>

namespace cdb::plan {
namespace {

// The ways to a file that cdb reads.
#ifdef CDB_ASSIMP_VERSION
constexpr std::string_view kImporter = "assimp " CDB_ASSIMP_VERSION;
constexpr std::string_view kImport = "let its name end in {2}";
#else
constexpr std::string_view kImporter;
constexpr std::string_view kImport =
    "install libassimp-dev and build cdb again, or convert it: `assimp export {0} {1}.obj`";
#endif
constexpr std::string_view kMeshio = "convert it: `meshio convert {0} {1}.ply`";
constexpr std::string_view kBlender = "open it in Blender and export OBJ, PLY or STL";
constexpr std::string_view kCad = "export STL from FreeCAD, or `gmsh {0} -2 -o {1}.stl`";
constexpr std::string_view kRobot = "write `robot NAME {{ file \"{0}\" }}`, outside of objects";
constexpr std::string_view kPdal = "convert it: `pdal translate {0} {1}.ply`";
constexpr std::string_view kNumpy =
    "write its dense grid of uint8 by `numpy.save(\"{1}.npy\", grid)`";
constexpr std::string_view kPoints =
    "type voxels reads .pcd and .ply; for hull, write its points as lines `v x y z` of an OBJ file";
constexpr std::string_view kUnpack = "unpack it first";
constexpr std::string_view kGdal = "convert it: `gdal_translate {0} {1}.tif`";
constexpr std::string_view kImage = "convert it: `convert {0} -colorspace Gray {1}.png`";
constexpr std::string_view kRaster = "make a grid of it, such as by `gdal_grid` or `pdal`";

struct Kind {
  std::string_view start;  ///< of the contents, in lower case; empty: known by the extension only
  std::string_view extensions;
  std::string_view kind, remedy;
};
/// What a download may be in place of any file.
constexpr Kind kWrappers[] = {
    {"version https://git-lfs", "", "a pointer of Git LFS", "run `git lfs pull` where it is"},
    {"\xff\xfe", "", "text in UTF-16", "save it as UTF-8"},
    {"\xfe\xff", "", "text in UTF-16", "save it as UTF-8"},
    {"<!doctype html", ".html .htm", "a web page", "download the file itself"},
    {"<html", "", "a web page", "download the file itself"},
    {"pk\x03\x04", ".zip .3mf", "a ZIP archive", kUnpack},
    {"\x1f\x8b", ".gz .tgz", "compressed by gzip", kUnpack},
    {"", ".xz .bz2 .7z .zst .tar .rar", "an archive", kUnpack},
};
constexpr Kind kModels[] = {
    {"<robot", ".urdf .xacro", "a robot description (URDF)", kRobot},
    {"<sdf", ".sdf .world", "a robot description (SDF)", kRobot},
    {"<mujoco", ".mjcf", "a robot description (MJCF)", kRobot},
    {"#usda", ".usda", "a scene (USD)", kBlender},
    {"pxr-usdc", ".usd .usdc .usdz", "a scene (USD)", kBlender},
    {"<collada", ".dae", "a scene (COLLADA)", kImport},
    {"gltf", ".glb", "a scene (glTF)", kImport},
    {"", ".gltf", "a scene (glTF)", kImport},
    {"kaydara fbx", ".fbx", "a scene (FBX)", kImport},
    {"<x3d", ".x3d", "a scene (X3D)", kImport},
    {"#vrml", ".wrl .vrml .x3dv", "a scene (VRML)", kBlender},
    {"", ".3ds", "a scene (3DS)", kImport},
    {"", ".3mf", "a package for printing (3MF)", kImport},
    {"<amf", ".amf", "a model for printing (AMF)", kImport},
    {"", ".lwo .ms3d .x .ac .ase .b3d .md2 .md5mesh", "a model of another program", kImport},
    {"blender", ".blend", "a Blender file", kBlender},
    {"", ".abc .max .ma .mb .c4d .skp", "a model of another program", kBlender},
    {"iso-10303-21", ".step .stp", "a CAD model (STEP)", kCad},
    {"", ".iges .igs .brep", "a CAD model", kCad},
    {"", ".fcstd .sldprt .ipt .f3d .3dm .dwg .dxf .scad", "a CAD model",
     "export STL from its program"},
    {"$meshformat", "", "a mesh of Gmsh", kMeshio},
    {"# vtk datafile", ".vtk", "a mesh of VTK", kMeshio},
    {"", ".vtu .vtp .msh .mesh .inp .bdf .med .xdmf", "a mesh of simulations", kMeshio},
    {"# .pcd", ".pcd .xyz .pts .las .laz .e57", "a point cloud", kPoints},
    {"ply\n", ".ply", "a PLY file", "let its name end in .ply"},
    {"ply\r", ".ply", "a PLY file", "let its name end in .ply"},
    {"off\n", ".off", "an OFF file", "let its name end in .off"},
    {"off\r", ".off", "an OFF file", "let its name end in .off"},
    {"solid ", ".stl", "an STL file", "let its name end in .stl"},
    {"\x89png", ".png", "an image (PNG)", "type heights reads heights"},
    {"ncols", ".asc", "a grid of heights", "type heights reads heights"},
};
constexpr Kind kHeights[] = {
    {"\x89png", ".png", "a PNG image", "let its name end in .png"},
    {{"ii*\0", 4}, ".tif .tiff", "a TIFF image", "let its name end in .tif"},
    {{"mm\0*", 4}, ".tif .tiff", "a TIFF image", "let its name end in .tif"},
    {{"ii+\0", 4}, ".tif .tiff", "a TIFF image", "let its name end in .tif"},
    {"ncols", ".asc", "an ESRI grid", "let its name end in .asc"},
    {"dsaa", ".grd", "a grid of Surfer", kGdal},
    {"dsbb", "", "a grid of Surfer", kGdal},
    {"north:", "", "a grid of GRASS", kGdal},
    {"{\"type\"", ".geojson", "a map of lines and points (GeoJSON)", kRaster},
    {"", ".shp .gpkg .kml", "a map of lines and points", kRaster},
    {"\xff\xd8\xff", ".jpg .jpeg", "an image (JPEG)", kImage},
    {"bm", ".bmp", "an image (BMP)", kImage},
    {"gif8", ".gif", "an image (GIF)", kImage},
    {"riff", ".webp", "an image (WebP)", kImage},
    {"v/1\x01", ".exr", "an image (EXR)", kGdal},
    {"p5", ".pgm", "an image (PGM)", kImage},
    {"", ".ppm .pnm .tga .psd .dds", "an image", kImage},
    {"cdf", ".nc", "a netCDF file", kGdal},
    {"\x89hdf", ".h5 .hdf .hdf5", "an HDF5 file", kGdal},
    {"", ".bil .bip .bsq .flt .img .dem .dt0 .dt1 .dt2 .vrt .adf .rst .jp2 .ter .xyz .grd",
     "a raster of another format", kGdal},
    {"", ".raw .r16 .r32", "heights without their number of columns",
     "convert them: `convert -size 1025x1025 -depth 16 gray:{0} {1}.png`"},
    {"", ".las .laz .e57 .pcd .ply", "a point cloud", kRaster},
    {"", ".obj .stl .off .glb .gltf .dae .fbx", "a model", "type surface reads models"},
};
constexpr Kind kVoxels[] = {
    {"#binvox", ".binvox", "a binvox file", "let its name end in .binvox"},
    {"\x93numpy", ".npy", "an array of NumPy", "let its name end in .npy"},
    {"# .pcd", ".pcd", "a point cloud (PCD)", "let its name end in .pcd"},
    {"ply\n", ".ply", "a PLY file", "let its name end in .ply"},
    {"ply\r", ".ply", "a PLY file", "let its name end in .ply"},
    {"bdv", ".vdb", "a sparse grid (OpenVDB)", kNumpy},
    {"nrrd", ".nrrd .nhdr", "a grid of NRRD", kNumpy},
    {"", ".nii .mhd .mha .dcm .vti .h5 .hdf5 .npz", "a grid of another program", kNumpy},
    {"vox ", ".vox .schem .schematic .qb", "a grid of another program", kNumpy},
    {"# octomap", ".bt .ot", "a tree of OctoMap",
     "convert it: `octree2pointcloud {0} {1}.pcd`, and let cell be its resolution"},
    {"lasf", ".las .laz", "a point cloud (LAS)", kPdal},
    {"astm-e57", ".e57", "a point cloud (E57)", kPdal},
    {"", ".xyz .pts .ptx .txt .csv", "a point cloud as text", kPdal},
    {"", ".obj .stl .off .glb .gltf .dae .fbx", "a model", "type surface reads models"},
    {"", ".asc .tif .tiff .png .hgt", "a grid of heights", "type heights reads heights"},
};

std::string LowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

/// Past the declaration, comments and blanks that may precede the first tag of XML.
std::string_view PastProlog(std::string_view text) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  for (;;) {
    text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
    const std::string_view end = text.starts_with("<!--") ? "-->"
                                 : text.starts_with("<?") ? "?>"
                                                          : "";
    const std::size_t at = end.empty() ? text.npos : text.find(end);
    if (at == text.npos) return text;
    text.remove_prefix(at + end.size());
  }
}

bool HasWord(std::string_view words, std::string_view word) {
  return !word.empty() &&
         fmt::format(" {} ", words).find(fmt::format(" {} ", word)) != std::string::npos;
}

/// The row of an extension; null if there is none.
const Kind* KindOf(std::string_view extension, std::span<const Kind> kinds) {
  const auto kind = std::ranges::find_if(
      kinds, [&](const Kind& row) { return HasWord(row.extensions, extension); });
  return kind == kinds.end() ? nullptr : &*kind;
}

ForeignModel ForeignOf(std::string_view name, std::string_view bytes, std::span<const Kind> kinds,
                       std::span<const std::string_view> readable) {
  const std::filesystem::path path(name);
  const std::string extension = LowerCase(path.extension().string());
  const std::string start = LowerCase(PastProlog(bytes.substr(0, 4096)).substr(0, 64));
  const auto found = [&](const Kind& kind) {
    return ForeignModel{
        std::string(kind.kind),
        fmt::format(fmt::runtime(kind.remedy), path.filename().string(), path.stem().string(),
                    kind.extensions.substr(0, kind.extensions.find(' ')))};
  };
  for (const auto table : {std::span<const Kind>(kWrappers), kinds})
    for (const Kind& kind : table)
      if (!kind.start.empty() && start.starts_with(kind.start) &&
          !HasWord(kind.extensions, extension))
        return found(kind);
  // Readable formats are in the tables only for what begins like them.
  if (std::ranges::find(readable, extension) != readable.end()) return {};
  const Kind* kind = KindOf(extension, kinds);
  if (kind == nullptr) kind = KindOf(extension, kWrappers);
  return kind == nullptr ? ForeignModel() : found(*kind);
}

}  // namespace

std::string_view ImporterOf(std::string_view extension) {
  const Kind* kind = KindOf(LowerCase(extension), kModels);
  return kind != nullptr && kind->remedy == kImport ? kImporter : std::string_view();
}

ForeignModel ForeignModelOf(std::string_view name, std::string_view bytes) {
  const std::string extension = std::filesystem::path(name).extension().string();
  const ForeignModel found = ForeignOf(name, bytes, kModels, kModelFormats);
  // A file that this build imports is foreign only if its contents are of another format.
  const bool is_by_extension = found.kind == ForeignOf(name, {}, kModels, kModelFormats).kind;
  return is_by_extension && !ImporterOf(extension).empty() ? ForeignModel() : found;
}

ForeignModel ForeignHeightsOf(std::string_view name, std::string_view bytes) {
  return ForeignOf(name, bytes, kHeights, kHeightFormats);
}

ForeignModel ForeignVoxelsOf(std::string_view name, std::string_view bytes) {
  return ForeignOf(name, bytes, kVoxels, kVoxelFormats);
}

}  // namespace cdb::plan
