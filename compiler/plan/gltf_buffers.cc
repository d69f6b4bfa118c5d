#include "compiler/plan/gltf_buffers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

namespace cdb::plan {
namespace {

using Json = nlohmann::json;

/// With `%20` and the like as the bytes that they stand for.
std::string Decoded(std::string_view uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const auto is_digit = [&](std::size_t at) {
      return at < uri.size() && std::isxdigit(static_cast<unsigned char>(uri[at])) != 0;
    };
    if (uri[i] != '%' || !is_digit(i + 1) || !is_digit(i + 2)) {
      text += uri[i];
      continue;
    }
    text += static_cast<char>(std::stoi(std::string(uri.substr(i + 1, 2)), nullptr, 16));
    i += 2;
  }
  return text;
}

/// Relative, and not out of the folder.
bool IsWithinFolder(const std::string& name) {
  const std::filesystem::path path(name);
  return !name.empty() && path.is_relative() && std::ranges::count(path, "..") == 0 &&
         name.find_first_of(std::string_view(":\\\0", 3)) == name.npos;
}

struct Buffer {
  std::string uri;
  std::size_t size;
};

/// Those in other files; none if the file is damaged.
std::vector<Buffer> BuffersOf(std::string_view bytes) {
  std::vector<Buffer> buffers;
  const Json gltf = Json::parse(bytes, nullptr, false);
  if (!gltf.is_object() || !gltf.contains("buffers") || !gltf["buffers"].is_array()) return {};
  for (const Json& buffer : gltf["buffers"]) {
    if (!buffer.is_object() || !buffer.contains("uri") || !buffer["uri"].is_string()) continue;
    const auto uri = buffer["uri"].get<std::string>();
    if (uri.starts_with("data:")) continue;
    if (!buffer.contains("byteLength") || !buffer["byteLength"].is_number_unsigned()) return {};
    buffers.push_back({uri, buffer["byteLength"].get<std::size_t>()});
  }
  return buffers;
}

bool IsGltf(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension == ".gltf";
}

}  // namespace

std::optional<std::string> WithGltfBuffers(const std::string& path, std::string bytes,
                                           const ReadFile& read, std::size_t max_bytes,
                                           std::string& why) {
  if (!IsGltf(path)) return bytes;
  for (const Buffer& buffer : BuffersOf(bytes)) {
    const std::string name = Decoded(buffer.uri);
    if (!IsWithinFolder(name)) {
      why = fmt::format("its data are in '{}', which is not in its folder", buffer.uri);
      return std::nullopt;
    }
    const auto data = read((std::filesystem::path(path).parent_path() / name).string(), why);
    if (!data) {
      why = fmt::format("its data are in '{}': {}", buffer.uri, why);
      return std::nullopt;
    }
    if (data->size() < buffer.size) {
      why = fmt::format("its data are in '{}', which has {} bytes instead of {}", buffer.uri,
                        data->size(), buffer.size);
      return std::nullopt;
    }
    if (buffer.size > max_bytes || bytes.size() > max_bytes - buffer.size) {
      why = fmt::format("it and its data have more than {} bytes", max_bytes);
      return std::nullopt;
    }
    bytes.append(*data, 0, buffer.size);
  }
  return bytes;
}

}  // namespace cdb::plan
