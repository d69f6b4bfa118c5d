#include "library/objects/solid_factory.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "compiler/plan/input_file.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/text/check.h"
#include "library/meshes/models.h"
#include "library/meshes/primitives.h"
#include "library/meshes/topology.h"
#include "library/objects/surface.h"
#include "library/scene_error.h"

namespace cdb::objects {
namespace {

using Eigen::Vector3d;
namespace fs = std::filesystem;

/// The torus at its own proportions: radii of the ring and of the tube, and its pieces.
constexpr double kTorusMajor = 3, kTorusMinor = 1;
constexpr std::size_t kTorusSegments = 16;

ConvexDecomposition TorusForm() {
  constexpr double major = kTorusMajor * kTorusMajor, minor = kTorusMinor * kTorusMinor;
  meshes::MassProperties properties;
  properties.volume = 2 * std::numbers::pi * std::numbers::pi * kTorusMajor * minor;
  const double across = major / 2 + minor * 5 / 8, along = major + minor * 3 / 4;
  properties.inertia = Vector3d(across, along, across).asDiagonal();
  const std::string source =
      fmt::format("torus {} {} {} {} {}", kTorusMajor, kTorusMinor, kTorusSegments,
                  meshes::kTorusCorners, meshes::kTorusFineness);
  return DecomposeOnce("torus", source, [&] {
    // With multiples of four, corners lie on the axes, so that the mesh is as large as the torus.
    const meshes::Mesh mesh =
        meshes::TorusMesh(kTorusMajor, kTorusMinor, kTorusSegments, meshes::kTorusCorners);
    return MakeDecomposition("torus", mesh, properties,
                             meshes::TorusHulls(kTorusMajor, kTorusMinor, kTorusSegments));
  });
}

ConvexDecomposition FormOfMesh(const std::string& name, const meshes::Mesh& mesh,
                               const meshes::DecomposeOptions& options = {}) {
  return MakeDecomposition(name, mesh, meshes::MassPropertiesOf(mesh),
                           meshes::Decompose(mesh, name, options));
}

/// `made`: the method of making the form. The extension of the file determines its format.
std::string SourceOf(const fs::path& file, std::string_view sha256, std::string_view made) {
  return fmt::format("{} {} {}", made, file.extension().string(), sha256);
}

ConvexDecomposition FormOfModel(const meshes::Model& model) {
  const std::string name(model.name);
  const fs::path file = meshes::PathOf(model, meshes::ModelFolders());
  const std::string bytes = meshes::ReadMeshFile(file);
  const std::string_view made = model.has_holes ? "closed mesh" : "mesh";
  return DecomposeOnce(name, SourceOf(file, plan::Sha256Hex(bytes), made), [&] {
    return FormOfMesh(name, meshes::ParseModel(model, bytes, file.string()));
  });
}

terrain::HeightOptions HeightOptionsOf(const schema::Call& call) {
  terrain::HeightOptions options;
  // Other values are the words `unit`, `file`, `refuse` and `lowest`.
  const schema::Number* cell = schema::AsNumber(ArgumentOf(call, "cell"));
  if (cell != nullptr) options.scale = Vector3d(cell->AsReal(), 1, cell->AsReal());
  if (const Vector3d* scale = schema::AsVector(ArgumentOf(call, "scale"))) {
    if (cell != nullptr)
      throw library::SceneError("heights has a cell as well as a scale",
                                "remove the cell; `scale` has the sides of a cell, too");
    if (!(scale->minCoeff() > 0))
      throw library::SceneError("the scale of heights must be more than 0 along each axis",
                                "for example `scale: (30, 1, 30)`");
    options.scale = *scale;
  }
  const schema::Value& no_data = ArgumentOf(call, "no_data");
  if (const schema::Number* height = schema::AsNumber(no_data)) {
    options.no_data = height->AsReal();
  } else if (std::get<schema::Word>(no_data).text == "lowest") {
    options.no_data = terrain::HeightOptions::Lowest();
  }
  return options;
}

ConvexDecomposition FormOfHeights(const std::string& name, const schema::Call& call,
                                  const std::string& bytes) {
  const auto& file = std::get<schema::Text>(ArgumentOf(call, "file")).text;
  return MakeSurface(name, std::make_shared<const terrain::HeightGrid>(
                               terrain::ParseHeights(bytes, file, HeightOptionsOf(call))));
}

/// The arguments that do not change the pieces.
ConvexDecomposition WithFrame(ConvexDecomposition form, const schema::Call& call) {
  struct Unit {
    std::string_view name;
    double metres;
  };
  constexpr Unit kUnits[] = {{"m", 1}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}};
  const auto word = [&](const char* argument) -> std::string_view {
    return std::get<schema::Word>(ArgumentOf(call, argument)).text;
  };
  const auto* unit = std::ranges::find(kUnits, word("unit"), &Unit::name);
  CDB_CHECK(unit != std::end(kUnits));
  form.unit = unit->metres;
  const std::string_view origin = word("origin");
  form.origin = origin == "file"  ? form.file_origin
                : origin == "box" ? Vector3d::Zero()
                                  : form.centre;
  return form;
}

/// The options of a mesh, and these as text, empty by default. Other values are the word `fit`.
std::pair<meshes::DecomposeOptions, std::string> OptionsOf(const schema::Call& call) {
  meshes::DecomposeOptions options;
  std::string text;
  if (const schema::Number* hulls = schema::AsNumber(ArgumentOf(call, "hulls"))) {
    options.hulls = static_cast<std::size_t>(hulls->AsReal());
    text += fmt::format(", hulls: {}", options.hulls);
  }
  if (const schema::Number* error = schema::AsNumber(ArgumentOf(call, "error"))) {
    options.error = error->AsReal();
    text += fmt::format(", error: {}", options.error);
  }
  return {options, text};
}

ConvexDecomposition FormOfFile(const schema::Call& call) {
  const auto& file = std::get<schema::Text>(ArgumentOf(call, "file")).text;
  const auto [options, words] =
      call.name == "mesh" ? OptionsOf(call) : std::pair<meshes::DecomposeOptions, std::string>();
  const std::string name = fmt::format("{}(\"{}\"{})", call.name, file, words);
  const auto* planned = std::get_if<schema::Text>(&ArgumentOf(call, "sha256"));
  const std::string bytes = meshes::ReadMeshFile(file);
  const std::string sha256 = plan::Sha256Hex(bytes);
  if (planned != nullptr && sha256 != planned->text)
    throw library::SceneError(
        fmt::format("{}: it differs from the file that the plan was made with; plan again", file));
  if (call.name == schema::kHeightsCall) return FormOfHeights(name, call, bytes);
  if (call.name == "surface")
    return WithFrame(MakeSurface(name, meshes::ParseMesh(bytes, file)), call);
  const auto make = [&, &options = options] {
    const meshes::Mesh mesh = meshes::ParseMesh(bytes, file);
    if (call.name == "mesh") return FormOfMesh(name, meshes::Watertight(mesh, file), options);
    const meshes::Hull hull = meshes::ConvexHull(mesh, file);
    const meshes::Mesh surface = meshes::SurfaceOf(hull);
    return MakeDecomposition(name, surface, meshes::MassPropertiesOf(surface), {{hull}, 0, 1});
  };
  return WithFrame(DecomposeOnce(name, SourceOf(file, sha256, call.name + words), make), call);
}

/// Null for a type with a closed form.
std::shared_ptr<const ConvexDecomposition> FormOf(const schema::Value& type) {
  if (const schema::Call* call = schema::AsCall(type))
    return std::make_shared<const ConvexDecomposition>(FormOfFile(*call));
  const std::string& name = std::get<schema::Word>(type).text;
  if (name == "torus") return std::make_shared<const ConvexDecomposition>(TorusForm());
  if (const meshes::Model* model = meshes::FindModel(name))
    return std::make_shared<const ConvexDecomposition>(FormOfModel(*model));
  return nullptr;
}

}  // namespace

Solid SolidFactory::Make(const schema::Value& type, const Vector3d& size, const Vector3d& aspect) {
  const auto* word = std::get_if<schema::Word>(&type);
  const std::string name = word != nullptr ? word->text : schema::ToText(type);
  auto found = forms_.find(name);
  if (found == forms_.end()) found = forms_.emplace(name, FormOf(type)).first;
  const auto& form = found->second;
  Solid solid;
  solid.sides = size.cwiseProduct(aspect);
  const bool is_native = size.isZero(0);
  if (is_native && (schema::AsCall(type) == nullptr || aspect != Vector3d::Ones()))
    throw library::SceneError(
        schema::AsCall(type) == nullptr
            ? fmt::format("a {} has no file that gives it a size, but the size is native", name)
            : "the size is native, but the aspect is not 1 : 1 : 1",
        schema::AsCall(type) == nullptr ? "write a size in m" : "remove the aspect");
  if (form == nullptr) {
    solid.shape = ShapeOf(name);
    return solid;
  }
  // Another aspect sets all sides.
  if (form->heights && aspect == Vector3d::Ones())
    if (const terrain::HeightGrid& grid = form->heights->grid(); !grid.unknown_scale.empty())
      throw library::SceneError(grid.unknown_scale, grid.scale_remedy);
  solid.shape = Shape::kCompound;
  if (is_native)
    solid.sides = form->native_side * form->unit * form->proportions;
  else if (aspect == Vector3d::Ones())
    solid.sides = size.cwiseProduct(form->proportions);
  auto& compound = compounds_[{form.get(), solid.sides.x(), solid.sides.y(), solid.sides.z()}];
  if (compound == nullptr) compound = std::make_shared<const Compound>(form, solid.sides);
  solid.compound = compound;
  return solid;
}

std::vector<std::shared_ptr<const ConvexDecomposition>> SolidFactory::Forms() const {
  std::vector<std::shared_ptr<const ConvexDecomposition>> forms;
  for (const auto& [name, form] : forms_)
    if (form != nullptr) forms.push_back(form);
  return forms;
}

namespace {

/// A smaller overlap of the parts of a mesh is not reported; rays measure volumes less exactly than
/// this.
constexpr double kNoticeableOverlap = 0.01;

}  // namespace

std::string ModelsText(const std::vector<std::shared_ptr<const ConvexDecomposition>>& forms) {
  std::string text;
  for (const auto& form : forms) {
    if (form->IsSurface()) {
      text += fmt::format("{}: {} triangle{}\n", form->name, form->PieceCount(),
                          form->PieceCount() == 1 ? "" : "s");
      continue;
    }
    const std::string twice =
        form->overlap > kNoticeableOverlap
            ? fmt::format(", parts overlap: mass and inertia count {:.3g} % of the volume twice",
                          100 * form->overlap)
            : "";
    text += fmt::format("{}: {} hull{}, volume error {:.3g} %, IoU {:.3f}{}\n", form->name,
                        form->pieces.size(), form->pieces.size() == 1 ? "" : "s",
                        100 * form->volume_error, form->iou, twice);
  }
  return text;
}

namespace {

constexpr std::string_view kKind = "form";
/// To be incremented with changes that affect a form but are not part of DecomposerVersion: reading
/// and closing of files, mass properties, the torus, and the storage format.
constexpr int kVersion = 4;

/// Appends the values passed to it.
class Writer {
 public:
  void Word(std::uint64_t word) {
    for (int i = 0; i < 8; ++i) bytes_ += static_cast<char>(word >> 8 * i & 0xff);
  }
  void Real(double real) { Word(std::bit_cast<std::uint64_t>(real)); }
  template <typename T>
  void Size(const std::vector<T>& items) {
    Word(items.size());
  }
  void Index(std::uint32_t index) { Word(index); }
  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Restores the values that Writer stored.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}

  void Real(double& real) { real = std::bit_cast<double>(Next()); }
  template <typename T>
  void Size(std::vector<T>& items) {
    // The data are those written; the limit guards against our own errors.
    const std::uint64_t size = Next();
    is_good_ = is_good_ && size <= bytes_.size();
    items.resize(is_good_ ? size : 0);
  }
  void Index(std::uint32_t& index) { index = static_cast<std::uint32_t>(Next()); }
  bool IsDone() const { return is_good_ && bytes_.empty(); }

 private:
  std::uint64_t Next() {
    is_good_ = is_good_ && bytes_.size() >= 8;
    if (!is_good_) return 0;
    std::uint64_t word = 0;
    for (std::size_t i = 8; i-- > 0;) word = word << 8 | static_cast<unsigned char>(bytes_[i]);
    bytes_.remove_prefix(8);
    return word;
  }

  std::string_view bytes_;
  bool is_good_ = true;
};

/// Visits everything in a form except its name, in storage order.
void Visit(auto& archive, ConvexDecomposition& form) {
  const auto reals = [&](auto& matrix) {
    for (double& real : matrix.reshaped()) archive.Real(real);
  };
  reals(form.proportions);
  archive.Real(form.native_side);
  reals(form.file_origin);
  archive.Real(form.volume);
  reals(form.centre);
  reals(form.origin);
  reals(form.second_moments);
  archive.Real(form.volume_error);
  archive.Real(form.iou);
  archive.Real(form.overlap);
  archive.Size(form.pieces);
  for (ConvexPiece& piece : form.pieces) {
    reals(piece.centre);
    reals(piece.half);
    archive.Size(piece.vertices);
    for (Eigen::Vector3d& vertex : piece.vertices) reals(vertex);
    archive.Size(piece.faces);
    for (meshes::Triangle& face : piece.faces)
      for (std::uint32_t& vertex : face) archive.Index(vertex);
  }
}

std::string ToBytes(ConvexDecomposition form) {
  Writer writer;
  Visit(writer, form);
  return writer.Take();
}

bool HasFacesOfItsVertices(const ConvexPiece& piece) {
  return std::ranges::all_of(piece.faces, [&](const meshes::Triangle& face) {
    return std::ranges::all_of(
        face, [&](std::uint32_t vertex) { return vertex < piece.vertices.size(); });
  });
}

std::optional<ConvexDecomposition> FromBytes(std::string_view bytes) {
  Reader reader(bytes);
  ConvexDecomposition form;
  Visit(reader, form);
  const bool is_whole = reader.IsDone() && !form.pieces.empty() &&
                        std::ranges::all_of(form.pieces, HasFacesOfItsVertices);
  return is_whole ? std::optional(std::move(form)) : std::nullopt;
}

}  // namespace

std::string DecompositionKey(std::string_view source) {
  return library::CacheKeyOf(
      fmt::format("{}\n{}\n{}", kVersion, meshes::DecomposerVersion(), source));
}

ConvexDecomposition DecomposeOnce(std::string name, std::string_view source,
                                  const std::function<ConvexDecomposition()>& make,
                                  const std::filesystem::path& folder) {
  const std::string key = DecompositionKey(source);
  std::optional<ConvexDecomposition> form;
  const auto find = [&] {
    if (const auto bytes = library::FindCached(folder, kKind, key)) form = FromBytes(*bytes);
    return form.has_value();
  };
  if (!find()) {
    const library::CacheLock lock(folder, kKind, key, [] {});
    if (!find()) {
      form = make();
      library::StoreCached(folder, kKind, key, ToBytes(*form));
    }
  }
  form->name = std::move(name);
  return *std::move(form);
}

}  // namespace cdb::objects
