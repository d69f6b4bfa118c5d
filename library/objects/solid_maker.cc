#include "library/objects/solid_maker.h"

#include <fmt/format.h>

#include <filesystem>
#include <numbers>

#include "compiler/calls.h"
#include "compiler/sha256.h"
#include "library/meshes/models.h"
#include "library/meshes/primitives.h"
#include "library/meshes/topology.h"
#include "library/objects/form_cache.h"
#include "library/scene_error.h"

namespace cdb::library {
namespace {

using Eigen::Vector3d;
namespace fs = std::filesystem;

/// The torus, when it keeps its proportions: radii of the ring and of the tube, and its pieces.
constexpr double kTorusMajor = 3, kTorusMinor = 1;
constexpr std::size_t kTorusSegments = 16;

Form TorusForm() {
  constexpr double major = kTorusMajor * kTorusMajor, minor = kTorusMinor * kTorusMinor;
  MassProperties properties;
  properties.volume = 2 * std::numbers::pi * std::numbers::pi * kTorusMajor * minor;
  const double across = major / 2 + minor * 5 / 8, along = major + minor * 3 / 4;
  properties.inertia = Vector3d(across, along, across).asDiagonal();
  const std::string source = fmt::format("torus {} {} {} {} {}", kTorusMajor, kTorusMinor,
                                         kTorusSegments, kTorusCorners, kTorusFineness);
  return FormOnce("torus", source, [&] {
    // Corners in multiples of four lie on the axes, so that the mesh is as large as the torus.
    const Mesh mesh = TorusMesh(kTorusMajor, kTorusMinor, kTorusSegments, kTorusCorners);
    return MakeForm("torus", mesh, properties,
                    TorusHulls(kTorusMajor, kTorusMinor, kTorusSegments));
  });
}

Form FormOfMesh(const std::string& name, const Mesh& mesh) {
  return MakeForm(name, mesh, MassPropertiesOf(mesh), Decompose(mesh, name));
}

/// `made`: how the form is made of the file. Its extension says how it is read.
std::string SourceOf(const fs::path& file, std::string_view sha256, std::string_view made) {
  return fmt::format("{} {} {}", made, file.extension().string(), sha256);
}

Form FormOfModel(const Model& model) {
  const std::string name(model.name);
  const fs::path file = PathOf(model, ModelFolders());
  const std::string bytes = ReadMeshFile(file);
  const std::string_view made = model.has_holes ? "closed mesh" : "mesh";
  return FormOnce(name, SourceOf(file, compiler::Sha256Hex(bytes), made),
                  [&] { return FormOfMesh(name, ParseModel(model, bytes, file.string())); });
}

Form FormOfFile(const compiler::Call& call) {
  const auto& file = std::get<compiler::Text>(ArgumentOf(call, "file")).text;
  const std::string name = fmt::format("{}(\"{}\")", call.name, file);
  const auto* planned = std::get_if<compiler::Text>(&ArgumentOf(call, "sha256"));
  const std::string bytes = ReadMeshFile(file);
  const std::string sha256 = compiler::Sha256Hex(bytes);
  if (planned != nullptr && sha256 != planned->text)
    throw SceneError(fmt::format("{}: it is not the file that was planned with; plan again", file));
  return FormOnce(name, SourceOf(file, sha256, call.name), [&] {
    const Mesh mesh = ParseMesh(bytes, file);
    if (call.name == "mesh") return FormOfMesh(name, Watertight(mesh, file));
    const Hull hull = ConvexHull(mesh, file);
    const Mesh surface = SurfaceOf(hull);
    return MakeForm(name, surface, MassPropertiesOf(surface), {{hull}, 0, 1});
  });
}

/// Null for what has a closed form.
std::shared_ptr<const Form> FormOf(const compiler::Value& type) {
  if (const compiler::Call* call = compiler::AsCall(type))
    return std::make_shared<const Form>(FormOfFile(*call));
  const std::string& name = std::get<compiler::Word>(type).text;
  if (name == "torus") return std::make_shared<const Form>(TorusForm());
  if (const Model* model = FindModel(name))
    return std::make_shared<const Form>(FormOfModel(*model));
  return nullptr;
}

}  // namespace

Solid SolidMaker::Make(const compiler::Value& type, const Vector3d& size, const Vector3d& aspect) {
  const auto* word = std::get_if<compiler::Word>(&type);
  const std::string name = word != nullptr ? word->text : compiler::ToText(type);
  auto found = forms_.find(name);
  if (found == forms_.end()) found = forms_.emplace(name, FormOf(type)).first;
  const auto& form = found->second;
  Solid solid;
  solid.sides = size.cwiseProduct(aspect);
  if (form == nullptr) {
    solid.shape = ShapeOf(name);
    return solid;
  }
  solid.shape = Shape::kCompound;
  if (aspect == Vector3d::Ones()) solid.sides = size.cwiseProduct(form->proportions);
  auto& compound = compounds_[{form.get(), solid.sides.x(), solid.sides.y(), solid.sides.z()}];
  if (compound == nullptr) compound = std::make_shared<const Compound>(form, solid.sides);
  solid.compound = compound;
  return solid;
}

std::vector<std::shared_ptr<const Form>> SolidMaker::Forms() const {
  std::vector<std::shared_ptr<const Form>> forms;
  for (const auto& [name, form] : forms_)
    if (form != nullptr) forms.push_back(form);
  return forms;
}

std::string FormsText(const std::vector<std::shared_ptr<const Form>>& forms) {
  std::string text;
  for (const auto& form : forms)
    text += fmt::format("{}: {} hull{}, volume error {:.3g} %, IoU {:.3f}\n", form->name,
                        form->pieces.size(), form->pieces.size() == 1 ? "" : "s",
                        100 * form->volume_error, form->iou);
  return text;
}

}  // namespace cdb::library
