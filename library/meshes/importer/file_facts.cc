// What a file says and assimp does not tell.
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "library/meshes/importer/scene_mesh.h"
#include "library/scene_error.h"

namespace cdb::importer {
namespace {

using library::SceneError;

std::string LowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower;
}

/// A little-endian number of `size` bytes; 0 beyond the end.
std::uint32_t NumberAt(std::string_view bytes, std::size_t at, int size) {
  std::uint32_t number = 0;
  for (int i = 0; i < size && at + static_cast<std::size_t>(i) < bytes.size(); ++i)
    number |= std::uint32_t{static_cast<unsigned char>(bytes[at + static_cast<std::size_t>(i)])}
              << 8 * i;
  return number;
}

/// The first bytes of a deflated or stored part of a ZIP archive, with its first tags.
std::string StartOf(std::string_view part, std::uint32_t method) {
  constexpr std::size_t kEnough = 1 << 16;
  if (method == 0) return std::string(part.substr(0, kEnough));
  std::string start(kEnough, '\0');
  z_stream stream = {};
  if (method != Z_DEFLATED || inflateInit2(&stream, -MAX_WBITS) != Z_OK) return {};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(part.data()));
  stream.avail_in = static_cast<uInt>(part.size());
  stream.next_out = reinterpret_cast<Bytef*>(start.data());
  stream.avail_out = static_cast<uInt>(start.size());
  inflate(&stream, Z_SYNC_FLUSH);
  start.resize(start.size() - stream.avail_out);
  inflateEnd(&stream);
  return start;
}

/// The beginning of the part whose entry in the directory of a ZIP archive is `at`; empty if it is
/// not there. Source: APPNOTE.TXT of PKWARE, 4.3.7 and 4.3.12.
std::string StartOfEntry(std::string_view zip, std::size_t at) {
  constexpr std::size_t kLocalSize = 30;
  const std::size_t local = NumberAt(zip, at + 42, 4);
  const std::size_t data =
      local + kLocalSize + NumberAt(zip, local + 26, 2) + NumberAt(zip, local + 28, 2);
  if (data > zip.size()) return {};
  return StartOf(zip.substr(data, NumberAt(zip, at + 20, 4)), NumberAt(zip, at + 10, 2));
}

/// The beginning of the model in a 3MF file: its only part of that kind, or the one with the usual
/// name.
std::string ModelOf(std::string_view zip) {
  constexpr std::string_view kEntry = "PK\x01\x02", kUsual = "3d/3dmodel.model";
  constexpr std::size_t kEntrySize = 46;
  std::vector<std::size_t> models, usual;
  for (std::size_t at = zip.find(kEntry); at != zip.npos; at = zip.find(kEntry, at + 1)) {
    if (at + kEntrySize > zip.size()) break;
    const std::string name = LowerCase(zip.substr(at + kEntrySize, NumberAt(zip, at + 28, 2)));
    if (name.ends_with(".model")) models.push_back(at);
    if (name == kUsual) usual.push_back(at);
  }
  if (models.size() != 1) models = usual;
  const std::string model = models.size() == 1 ? StartOfEntry(zip, models[0]) : "";
  if (model.find("<model") == model.npos)
    throw SceneError("has no part 3D/3dmodel.model in UTF-8", "");
  return model;
}

/// The value of an attribute in the first tag of this name; nullopt if there is none.
std::optional<std::string_view> AttributeOf(std::string_view xml, std::string_view tag,
                                            std::string_view attribute) {
  constexpr std::string_view kBlank = " \t\r\n";
  const std::size_t at = xml.find(tag);
  if (at == xml.npos) return std::nullopt;
  const std::string_view inside = xml.substr(at, std::min(xml.find('>', at), xml.size()) - at);
  for (std::size_t i = inside.find(attribute); i != inside.npos;
       i = inside.find(attribute, i + 1)) {
    const std::size_t equals = inside.find_first_not_of(kBlank, i + attribute.size());
    if (i == 0 || kBlank.find(inside[i - 1]) == kBlank.npos || equals == inside.npos ||
        inside[equals] != '=')
      continue;
    const std::size_t quote = inside.find_first_of("'\"", equals);
    if (quote == inside.npos) break;
    return inside.substr(quote + 1, inside.find(inside[quote], quote + 1) - quote - 1);
  }
  return std::nullopt;
}

struct Unit {
  std::string_view name;
  double metres;
};
constexpr Unit kUnits[] = {{"micron", 1e-6},     {"millimeter", 1e-3}, {"millimeters", 1e-3},
                           {"centimeter", 1e-2}, {"inch", 0.0254},     {"foot", 0.3048},
                           {"feet", 0.3048},     {"meter", 1}};

double MetresOf(std::string_view name) {
  const auto* unit = std::ranges::find(kUnits, LowerCase(name), &Unit::name);
  if (unit == std::end(kUnits))
    throw SceneError(fmt::format("its unit is `{}`, which is not one of the format", name), "");
  return unit->metres;
}

/// A reader must refuse extensions that it does not know. Those of materials change no surface.
void CheckExtensionsOf3mf(std::string_view model) {
  std::string_view names = AttributeOf(model, "<model", "requiredextensions").value_or("");
  while (!names.empty()) {
    const std::size_t end = std::min(names.find(' '), names.size());
    const std::string name(names.substr(0, end));
    names.remove_prefix(std::min(end + 1, names.size()));
    const std::string_view address = AttributeOf(model, "<model", "xmlns:" + name).value_or(name);
    if (!name.empty() && address.find("/material/") == address.npos)
      throw SceneError(
          fmt::format("needs the 3MF extension {}, which assimp does not apply", address),
          "export it without, or as OBJ, PLY or STL");
  }
}

/// X3D has one unit for each category, in the head.
double UnitOfX3d(std::string_view xml) {
  for (std::size_t at = xml.find("<unit"); at != xml.npos; at = xml.find("<unit", at + 1)) {
    const std::string_view tag = xml.substr(at);
    if (AttributeOf(tag, "<unit", "category") != "length") continue;
    const std::string_view factor = AttributeOf(tag, "<unit", "conversionFactor").value_or("1");
    double metres = 0;
    std::from_chars(factor.data(), factor.data() + factor.size(), metres);
    if (!(metres > 0 && std::isfinite(metres)))
      throw SceneError(fmt::format("its unit of length is `{}` m", factor), "");
    return metres;
  }
  return 1;
}

}  // namespace

double UnitOf(std::string_view bytes, std::string_view extension) {
  if (extension == ".3mf") {
    const std::string model = ModelOf(bytes);
    CheckExtensionsOf3mf(model);
    return MetresOf(AttributeOf(model, "<model", "unit").value_or("millimeter"));
  }
  if (extension == ".amf")
    return MetresOf(AttributeOf(bytes, "<amf", "unit").value_or("millimeter"));
  return extension == ".x3d" ? UnitOfX3d(bytes) : 1;
}

namespace {

using Json = nlohmann::json;

/// Extensions that assimp applies or reports, or that do not change the surface.
bool IsTaken(std::string_view extension) {
  for (const std::string_view part : {"_materials_", "_texture_", "_lights_", "_animation_"})
    if (extension.find(part) != extension.npos) return true;
  return extension == "KHR_draco_mesh_compression" || extension == "KHR_xmp_json_ld" ||
         extension == "KHR_technique_webgl" || extension == "KHR_techniques_webgl" ||
         extension == "KHR_node_visibility";
}

std::string_view JsonOf(std::string_view bytes) {
  constexpr std::size_t kHead = 20;
  if (!bytes.starts_with("glTF") || bytes.size() < kHead) return bytes;
  return bytes.substr(kHead, NumberAt(bytes, 12, 4));
}

void CheckVersion(const Json& gltf) {
  const std::string version = gltf.value("asset", Json::object()).value("version", "");
  if (!version.starts_with("2."))
    throw SceneError(fmt::format("is of glTF version {}, not 2", version),
                     "import it in a program and export version 2.0");
}

void CheckExtensions(const Json& gltf) {
  for (const Json& name : gltf.value("extensionsRequired", Json::array())) {
    const std::string extension = name.is_string() ? name.get<std::string>() : "";
    if (!IsTaken(extension))
      throw SceneError(
          fmt::format("needs the glTF extension {}, which assimp does not apply", extension),
          "export it without, or as OBJ, PLY or STL");
  }
}

std::string Base64(std::string_view bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve(4 * (bytes.size() / 3 + 1));
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : kDigits[three >> (18 - 6 * k) & 63];
  }
  return text;
}

/// Puts the data of other files, which are at the end of `bytes`, into the URIs that name them.
/// False if there are none.
bool EmbedBuffers(Json& gltf, std::string_view bytes) {
  std::size_t total = 0;
  std::vector<Json*> others;
  for (Json& buffer : gltf["buffers"]) {
    const std::string uri = buffer.value("uri", "");
    if (uri.empty() || uri.starts_with("data:")) continue;
    const std::size_t size = buffer.value("byteLength", std::size_t{0});
    if (size > bytes.size() - total)
      throw SceneError(fmt::format("its data are in another file, '{}'", uri),
                       "pack it into one file: `assimp export FILE.gltf FILE.glb`");
    total += size;
    others.push_back(&buffer);
  }
  bytes.remove_prefix(bytes.size() - total);
  for (Json* buffer : others) {
    const std::size_t size = buffer->value("byteLength", std::size_t{0});
    (*buffer)["uri"] = "data:application/octet-stream;base64," + Base64(bytes.substr(0, size));
    bytes.remove_prefix(size);
  }
  return !others.empty();
}

/// assimp copies other numbers as they stand.
void CheckPositions(const Json& gltf) {
  constexpr int kFloat = 5126;
  const Json accessors = gltf.value("accessors", Json::array());
  for (const Json& mesh : gltf.value("meshes", Json::array()))
    for (const Json& part : mesh.value("primitives", Json::array())) {
      const std::size_t at =
          part.value("attributes", Json::object()).value("POSITION", accessors.size());
      if (at < accessors.size() && accessors[at].value("componentType", 0) != kFloat)
        throw SceneError("its positions are not of the type float",
                         "export it again without quantisation");
    }
}

}  // namespace

std::string CheckedGltf(std::string bytes) {
  Json gltf;
  std::istringstream json{std::string(JsonOf(bytes))};
  try {
    json >> gltf;
  } catch (const Json::exception&) {
    gltf = nullptr;
  }
  if (!gltf.is_object()) throw SceneError("is not a glTF file: its JSON has an error", "");
  try {
    CheckVersion(gltf);
    CheckExtensions(gltf);
    if (gltf.value("meshes", Json::array()).is_array()) CheckPositions(gltf);
    // Data of other files may follow the JSON.
    const auto end =
        bytes.starts_with("glTF") ? bytes.size() : static_cast<std::size_t>(json.tellg());
    if (gltf.value("buffers", Json()).is_array() &&
        EmbedBuffers(gltf, std::string_view(bytes).substr(std::min(end, bytes.size()))))
      return gltf.dump();
  } catch (const Json::exception& error) {
    throw SceneError(fmt::format("is not a valid glTF file: {}", error.what()), "");
  }
  return bytes;
}

}  // namespace cdb::importer
