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
constexpr std::string_view kParts = "name the mesh files that it refers to, one for each object";
constexpr std::string_view kPoints = "write its points as lines `v x y z` of an OBJ file, for hull";
constexpr std::string_view kUnpack = "unpack it first";

struct Kind {
  std::string_view start;  ///< of the contents, in lower case; empty: known by the extension only
  std::string_view extensions;
  std::string_view kind, remedy;
};
constexpr Kind kKinds[] = {
    {"version https://git-lfs", "", "a pointer of Git LFS", "run `git lfs pull` where it is"},
    {"\xff\xfe", "", "text in UTF-16", "save it as UTF-8"},
    {"\xfe\xff", "", "text in UTF-16", "save it as UTF-8"},
    {"<!doctype html", ".html .htm", "a web page", "download the file itself"},
    {"<html", "", "a web page", "download the file itself"},
    {"<robot", ".urdf .xacro", "a robot description (URDF)", kParts},
    {"<sdf", ".sdf .world", "a scene (SDF)", kParts},
    {"<mujoco", ".mjcf", "a scene (MJCF)", kParts},
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
    {"# .pcd", ".pcd .xyz .pts .las .laz .e57", "a cloud of points", kPoints},
    {"pk\x03\x04", ".zip .3mf", "a ZIP archive", kUnpack},
    {"\x1f\x8b", ".gz .tgz", "compressed by gzip", kUnpack},
    {"", ".xz .bz2 .7z .zst .tar .rar", "an archive", kUnpack},
    {"ply\n", ".ply", "a PLY file", "let its name end in .ply"},
    {"ply\r", ".ply", "a PLY file", "let its name end in .ply"},
    {"off\n", ".off", "an OFF file", "let its name end in .off"},
    {"off\r", ".off", "an OFF file", "let its name end in .off"},
    {"solid ", ".stl", "an STL file", "let its name end in .stl"},
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
const Kind* KindOf(std::string_view extension) {
  const auto* kind = std::ranges::find_if(
      kKinds, [&](const Kind& row) { return HasWord(row.extensions, extension); });
  return kind == std::end(kKinds) ? nullptr : kind;
}

}  // namespace

std::string_view ImporterOf(std::string_view extension) {
  const Kind* kind = KindOf(LowerCase(extension));
  return kind != nullptr && kind->remedy == kImport ? kImporter : std::string_view();
}

ForeignModel ForeignModelOf(std::string_view name, std::string_view bytes) {
  const std::filesystem::path path(name);
  const std::string extension = LowerCase(path.extension().string());
  const std::string start = LowerCase(PastProlog(bytes.substr(0, 4096)).substr(0, 64));
  const auto found = [&](const Kind& kind) {
    return ForeignModel{
        std::string(kind.kind),
        fmt::format(fmt::runtime(kind.remedy), path.filename().string(), path.stem().string(),
                    kind.extensions.substr(0, kind.extensions.find(' ')))};
  };
  for (const Kind& kind : kKinds)
    if (!kind.start.empty() && start.starts_with(kind.start) &&
        !HasWord(kind.extensions, extension))
      return found(kind);
  // Readable formats are in the table only for what begins like them.
  for (const std::string_view readable : {".obj", ".ply", ".off", ".stl"})
    if (extension == readable) return {};
  const Kind* kind = KindOf(extension);
  return kind == nullptr || !ImporterOf(extension).empty() ? ForeignModel() : found(*kind);
}

}  // namespace cdb::plan
