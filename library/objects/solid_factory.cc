#include "library/objects/solid_factory.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "compiler/analysis/soft.h"
#include "compiler/analysis/trace.h"
#include "compiler/plan/foreign_model.h"
#include "compiler/plan/input_file.h"
#include "compiler/plan/kept_files.h"
#include "compiler/schema/parametrised_words.h"
#include "dsl/text/check.h"
#include "library/meshes/primitives.h"
#include "library/meshes/topology.h"
#include "library/objects/formula_ground.h"
#include "library/objects/ground_files.h"
#include "library/objects/models.h"
#include "library/objects/parts.h"
#include "library/objects/soft_form.h"
#include "library/objects/surface.h"
#include "library/scene_error.h"

namespace cdb::objects {
namespace {

using Eigen::Vector3d;
namespace fs = std::filesystem;

/// The torus at its own proportions: radii of the ring and of the tube, and its pieces.
constexpr double kTorusMajor = 3, kTorusMinor = 1;
constexpr std::size_t kTorusSegments = 16;

/// Of a file, each taken as a hull.
constexpr std::size_t kMostParts = 1024;

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

ConvexDecomposition WithLeftOut(ConvexDecomposition form, const meshes::Mesh& read) {
  form.left_out = read.left_out;
  return form;
}

/// Without pieces if it is not to be decomposed.
ConvexDecomposition FormOfMesh(const std::string& name, const meshes::Mesh& mesh,
                               const meshes::DecomposeOptions& options, const Reading& reading) {
  return MakeDecomposition(
      name, mesh, meshes::MassPropertiesOf(mesh),
      reading.decomposes ? meshes::Decompose(mesh, name, options) : meshes::Decomposition{});
}

meshes::DecomposeOptions WithProgress(meshes::DecomposeOptions options, const std::string& name,
                                      const Reading& reading) {
  if (reading.progress)
    options.progress = [&](std::size_t pieces) { reading.progress(name, pieces); };
  return options;
}

/// The result of `make`, which is not stored if it has no pieces.
ConvexDecomposition Decomposed(const std::string& name, const std::string& source,
                               const Reading& reading,
                               const std::function<ConvexDecomposition()>& make) {
  if (reading.decomposes) return DecomposeOnce(name, source, make);
  if (auto cached = FindDecomposition(name, source)) return *std::move(cached);
  return make();
}

/// `made`: the method of making the form. The extension of the file determines its format.
std::string SourceOf(const fs::path& file, std::string_view sha256, std::string_view made) {
  const std::string extension = file.extension().string();
  const std::string_view importer = plan::ImporterOf(extension);
  return fmt::format("{} {} {}{}{}", made, extension, sha256, importer.empty() ? "" : " ",
                     importer);
}

ConvexDecomposition FormOfModel(const Model& model, const Reading& reading) {
  const std::string name(model.name);
  const fs::path file = PathOf(model, ModelFolders());
  const std::string bytes = meshes::ReadMeshFile(file);
  const std::string_view made = model.has_holes ? "closed mesh" : "mesh";
  return Decomposed(name, SourceOf(file, plan::Sha256Hex(bytes), made), reading, [&] {
    return FormOfMesh(name, ParseModel(model, bytes, file.string()),
                      WithProgress({}, name, reading), reading);
  });
}

/// The arguments that do not change the pieces.
ConvexDecomposition WithFrame(ConvexDecomposition form, const schema::Call& call) {
  form.unit = MetresOfFile(call);
  const std::string_view origin = std::get<schema::Word>(ArgumentOf(call, "origin")).text;
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
  if (std::get<schema::Word>(ArgumentOf(call, "parts")).text == "given") text += ", parts: given";
  return {options, text};
}

/// A decomposition of the parts of the file, which are convex.
ConvexDecomposition FormOfParts(const std::string& name, const std::string& bytes,
                                const std::string& file) {
  std::vector<meshes::Hull> hulls;
  const meshes::Mesh mesh =
      meshes::JoinConvexParts(meshes::ParseParts(bytes, file, kMostParts), file, hulls);
  return MakeDecomposition(name, mesh, meshes::MassPropertiesOf(mesh),
                           meshes::Assessed(std::move(hulls), mesh));
}

/// Hulls that fit less are refused, unless the scenario accepts it.
constexpr double kLeastIou = 0.5;

void CheckIou(const ConvexDecomposition& form, const schema::Call& call) {
  const schema::Number* given = schema::AsNumber(ArgumentOf(call, "iou"));
  const double least = given != nullptr ? given->AsReal() : kLeastIou;
  if (form.pieces.empty() || form.iou >= least) return;
  const std::size_t hulls = form.pieces.size();
  throw library::SceneError(
      fmt::format("{}: {} with an IoU of {:.2g} {} not fit the mesh; {:.2g} is the least",
                  form.name, hulls == 1 ? "1 convex hull" : fmt::format("{} convex hulls", hulls),
                  form.iou, hulls == 1 ? "does" : "do", least),
      fmt::format("allow more hulls, such as `hulls: {}`, or accept it: `iou: {:.2g}`",
                  analysis::HullsForGoodFit(hulls, form.iou), std::floor(100 * form.iou) / 100));
}

ConvexDecomposition FormOfFile(const schema::Call& call, const Reading& reading) {
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
  if (IsGroundFile(call)) return GroundOfFile(name, call, bytes);
  if (call.name == "surface") {
    const meshes::Mesh mesh = meshes::ParseMesh(bytes, file);
    return WithFrame(WithLeftOut(MakeSurface(name, mesh), mesh), call);
  }
  const bool is_mesh = call.name == "mesh";
  const bool is_given =
      is_mesh && std::get<schema::Word>(ArgumentOf(call, "parts")).text == "given";
  const auto make = [&, &options = options] {
    if (is_given) return FormOfParts(name, bytes, file);
    const meshes::Mesh mesh = meshes::ParseMesh(bytes, file);
    if (is_mesh)
      return WithLeftOut(FormOfMesh(name, meshes::Watertight(mesh, file),
                                    WithProgress(options, name, reading), reading),
                         mesh);
    const meshes::Hull hull = meshes::ConvexHull(mesh, file);
    const meshes::Mesh surface = meshes::SurfaceOf(hull);
    return WithLeftOut(
        MakeDecomposition(name, surface, meshes::MassPropertiesOf(surface), {{hull}, 0, 1}), mesh);
  };
  ConvexDecomposition form =
      WithFrame(Decomposed(name, SourceOf(file, sha256, call.name + words), reading, make), call);
  if (is_mesh) CheckIou(form, call);
  return form;
}

plan::FileMemo<Form>& KeptForms() {
  static plan::FileMemo<Form> kept;
  return kept;
}

constexpr std::string_view kCompoundWord = "compound";

/// Null for a type with a closed form, and for a soft body.
Form FormOf(const schema::Value& type, const Reading& reading = {}) {
  if (analysis::IsSoft(type)) return nullptr;
  const std::string key = schema::ToText(type) + (reading.decomposes ? "" : " read only");
  const schema::Call* call = schema::AsCall(type);
  if (call != nullptr && call->name == kCompoundWord)
    return std::make_shared<const ConvexDecomposition>(MakeCompoundOfParts(
        *call, [&](const schema::Value& part) { return FormOf(part, reading); }));
  if (call != nullptr && IsFormulaGround(*call)) return FormulaGround(*call);
  if (call != nullptr)
    return KeptForms().Of(std::get<schema::Text>(ArgumentOf(*call, "file")).text, key, [&] {
      return std::make_shared<const ConvexDecomposition>(FormOfFile(*call, reading));
    });
  const std::string& name = std::get<schema::Word>(type).text;
  if (name == "torus") return std::make_shared<const ConvexDecomposition>(TorusForm());
  if (const Model* model = FindModel(name))
    return KeptForms().Of(PathOf(*model, ModelFolders()).string(), key, [&] {
      return std::make_shared<const ConvexDecomposition>(FormOfModel(*model, reading));
    });
  return nullptr;
}

}  // namespace

double MetresOfFile(const schema::Call& type) {
  struct Unit {
    std::string_view name;
    double metres;
  };
  constexpr Unit kUnits[] = {{"m", 1}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}};
  const auto* unit =
      std::ranges::find(kUnits, std::get<schema::Word>(ArgumentOf(type, "unit")).text, &Unit::name);
  CDB_CHECK(unit != std::end(kUnits));
  return unit->metres;
}

bool IsDecomposed(const schema::Value& type) {
  if (const schema::Call* call = schema::AsCall(type)) {
    if (call->name != kCompoundWord) return !analysis::IsSurface(*call) && !analysis::IsSoft(type);
    return std::ranges::any_of(schema::PartsOf(*call), [](const schema::Value& part) {
      const schema::Call* mesh = schema::AsCall(ArgumentOf(*schema::AsCall(part), "type"));
      return mesh != nullptr && mesh->name == "mesh";
    });
  }
  const auto* word = std::get_if<schema::Word>(&type);
  return word != nullptr && FindModel(word->text) != nullptr;
}

Solid SolidFactory::Make(const schema::Value& type, const Vector3d& size, const Vector3d& aspect,
                         const Eigen::Vector2d& exponents) {
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
    // A soft body has the box of its nodes; its margin adds to it.
    solid.shape = analysis::IsSoft(type) ? Shape::kCuboid : ShapeOf(name);
    if (analysis::IsOfFile(type))
      solid.sides = SoftFormOf(*schema::AsCall(type))->SidesOf(size.maxCoeff(), aspect);
    if (solid.shape == Shape::kSuperellipsoid) solid.exponents = exponents;
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

std::size_t ModelReadings() { return KeptForms().readings(); }

namespace {

/// A smaller overlap of the parts of a mesh is not reported; rays measure volumes less exactly than
/// this.
constexpr double kNoticeableOverlap = 0.01;

/// Without the name.
std::string TextOf(const ConvexDecomposition& form) {
  const auto count = [](std::size_t number, const char* what) {
    return fmt::format("{} {}{}", number, what, number == 1 ? "" : "s");
  };
  const std::string left_out =
      form.left_out.empty() ? "" : fmt::format(", left out: {}", form.left_out);
  if (form.points_compared > 0)
    return fmt::format("{}, up to {:.3g} m from the formula at {} points",
                       count(form.PieceCount(), "triangle"), form.deviation, form.points_compared);
  if (form.voxels) {
    const auto& [columns, rows, layers] = form.voxels->counts;
    return fmt::format("{} of {} x {} x {} cells of {:g} m are solid, {}",
                       form.voxels->SolidCount(), columns, rows, layers, form.voxels->cell,
                       count(form.PieceCount(), "triangle"));
  }
  if (form.IsSurface()) return count(form.PieceCount(), "triangle") + left_out;
  std::string text =
      fmt::format("{}, volume error {:.3g} %, IoU {:.3f}", count(form.pieces.size(), "hull"),
                  100 * form.volume_error, form.iou);
  if (form.hull_overlap > kNoticeableOverlap)
    text += fmt::format(", hulls overlap by {:.3g} %", 100 * form.hull_overlap);
  if (form.overlap > kNoticeableOverlap)
    text += fmt::format(", parts overlap: mass and inertia count {:.3g} % of the volume twice",
                        100 * form.overlap);
  return text + left_out;
}

}  // namespace

std::string ModelsText(const std::vector<std::shared_ptr<const ConvexDecomposition>>& forms) {
  std::string text;
  for (const auto& form : forms) text += fmt::format("{}: {}\n", form->name, TextOf(*form));
  return text;
}

namespace {

/// The file of the type, if it has one that is not on this machine.
analysis::ModelFault MissingFile(const schema::Value& type) {
  if (const schema::Call* call = schema::AsCall(type)) {
    for (const std::string_view file : schema::FilesOf(*call)) {
      const std::string fault = plan::WhyNotReadable(std::string(file));
      if (!fault.empty()) return {fmt::format("{}: {}", file, fault), "", true};
    }
    return {};
  }
  const Model* model = FindModel(std::get<schema::Word>(type).text);
  if (model == nullptr) return {};
  try {
    PathOf(*model, ModelFolders());
  } catch (const library::SceneError& error) {
    return {error.cause(), error.remedy(), true};
  }
  return {};
}

analysis::ModelFacts FactsOf(const std::shared_ptr<const SoftForm>& form,
                             const schema::Call& type) {
  analysis::ModelFacts facts;
  facts.has_size = true;
  facts.sides = form->native_side * form->proportions;
  facts.tetrahedra = {form, &form->mesh};
  facts.text = fmt::format("soft(\"{}\"): {}; {:.4g} x {:.4g} x {:.4g} m at `size native`",
                           std::get<schema::Text>(ArgumentOf(type, "file")).text, TextOf(*form),
                           facts.sides.x(), facts.sides.y(), facts.sides.z());
  return facts;
}

}  // namespace

std::optional<analysis::ModelFacts> ReadModel(const schema::Value& type, const Reading& reading,
                                              analysis::ModelFault& why) {
  const schema::Call* call = schema::AsCall(type);
  why = MissingFile(type);
  if (why.is_missing) return std::nullopt;
  analysis::ModelFacts facts;
  std::shared_ptr<const ConvexDecomposition> form;
  try {
    if (analysis::IsOfFile(type)) return FactsOf(SoftFormOf(*call), *call);
    form = FormOf(type, reading);
  } catch (const library::SceneError& error) {
    why = {error.cause(), error.remedy()};
    return std::nullopt;
  }
  if (analysis::IsSoft(type)) return facts;
  if (form == nullptr) {
    const Solid solid{ShapeOf(std::get<schema::Word>(type).text)};
    facts.placed.y() = -solid.BoxCentre();
    return facts;
  }
  facts.has_size =
      call != nullptr && (!form->heights || form->heights->grid().unknown_scale.empty());
  facts.sides =
      facts.has_size ? form->native_side * form->unit * form->proportions : form->proportions;
  facts.placed = form->origin;
  if (form->PieceCount() == 0) return facts;
  facts.hulls = form->pieces.size();
  if (!form->IsSurface()) facts.iou = form->iou;
  if (call != nullptr && call->name == kCompoundWord) return facts;  // without a file to describe
  facts.text = fmt::format("{}: {}", form->name, TextOf(*form));
  if (facts.has_size)
    facts.text += fmt::format("; {:.4g} x {:.4g} x {:.4g} m at `size native`", facts.sides.x(),
                              facts.sides.y(), facts.sides.z());
  return facts;
}

namespace {

constexpr std::string_view kKind = "form";
/// To be incremented with changes that affect a form but are not part of DecomposerVersion: reading
/// and closing of files, mass properties, the torus, and the storage format.
constexpr int kVersion = 6;

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
  archive.Real(form.hull_overlap);
  archive.Size(form.left_out);
  for (char& c : form.left_out) archive.Character(c);
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
  library::ByteWriter writer;
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
  library::ByteReader reader(bytes);
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

std::optional<ConvexDecomposition> FindDecomposition(const std::string& name,
                                                     std::string_view source,
                                                     const std::filesystem::path& folder) {
  const auto bytes = library::FindCached(folder, kKind, DecompositionKey(source));
  std::optional<ConvexDecomposition> form;
  if (bytes) form = FromBytes(*bytes);
  if (form) form->name = name;
  return form;
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
