#include "library/meshes/hull_cache.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <bit>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <sstream>

#include "compiler/sha256.h"

namespace cdb::library {
namespace {

namespace fs = std::filesystem;

// To be raised with the layout of the file.
constexpr std::string_view kMagic = "cdb hulls 1\n";
constexpr std::size_t kDigest = 64;

void PutWord(std::uint64_t word, std::string& bytes) {
  for (int i = 0; i < 8; ++i) bytes += static_cast<char>(word >> 8 * i & 0xff);
}
void PutReal(double real, std::string& bytes) {
  PutWord(std::bit_cast<std::uint64_t>(real), bytes);
}
void PutPoints(const std::vector<Eigen::Vector3d>& points, std::string& bytes) {
  PutWord(points.size(), bytes);
  for (const Eigen::Vector3d& point : points)
    for (const double coordinate : point) PutReal(coordinate, bytes);
}

/// What Put wrote; nothing where the bytes end too soon.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}

  std::optional<std::uint64_t> Word() {
    if (bytes_.size() < 8) return std::nullopt;
    std::uint64_t word = 0;
    for (std::size_t i = 8; i-- > 0;) word = word << 8 | static_cast<unsigned char>(bytes_[i]);
    bytes_.remove_prefix(8);
    return word;
  }
  std::optional<double> Real() {
    const auto word = Word();
    return word ? std::optional(std::bit_cast<double>(*word)) : std::nullopt;
  }
  std::size_t left() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
};

std::string ToBytes(const Decomposition& decomposition, std::string_view key) {
  std::string bytes(kMagic);
  bytes += key;
  PutReal(decomposition.volume_error, bytes);
  PutReal(decomposition.iou, bytes);
  PutWord(decomposition.hulls.size(), bytes);
  for (const Hull& hull : decomposition.hulls) PutPoints(hull.vertices, bytes);
  return bytes + compiler::Sha256Hex(bytes);
}

std::optional<Decomposition> FromBytes(std::string_view bytes, std::string_view key) {
  const std::size_t head = kMagic.size() + key.size();
  if (bytes.size() < head + kDigest || !bytes.starts_with(kMagic) ||
      bytes.substr(kMagic.size(), key.size()) != key)
    return std::nullopt;
  const std::string_view body = bytes.substr(0, bytes.size() - kDigest);
  if (compiler::Sha256Hex(body) != bytes.substr(body.size())) return std::nullopt;
  // From here on it is what ToBytes wrote; the bounds guard against our own mistakes.
  Reader reader(body.substr(head));
  const auto volume_error = reader.Real(), iou = reader.Real();
  const auto hulls = reader.Word();
  if (!hulls || *hulls == 0 || *hulls > reader.left()) return std::nullopt;
  Decomposition decomposition;
  decomposition.volume_error = *volume_error;
  decomposition.iou = *iou;
  for (std::uint64_t i = 0; i < *hulls; ++i) {
    const auto count = reader.Word();
    if (!count || *count > reader.left() / 24) return std::nullopt;
    Hull& hull = decomposition.hulls.emplace_back();
    for (std::uint64_t k = 0; k < *count; ++k) {
      Eigen::Vector3d& vertex = hull.vertices.emplace_back();
      for (double& coordinate : vertex) coordinate = *reader.Real();
    }
  }
  return reader.left() == 0 ? std::optional(std::move(decomposition)) : std::nullopt;
}

std::optional<Decomposition> Find(const fs::path& file, std::string_view key) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream bytes;
  // Unlike its iterators, this does not throw where reading fails.
  if (!stream || !(bytes << stream.rdbuf())) return std::nullopt;
  return FromBytes(bytes.view(), key);
}

/// False, with nothing left behind, where it cannot be written.
bool Store(const std::string& bytes, const fs::path& file) {
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error) return false;
  // A home may be shared by machines, and a process may have several threads here.
  static std::atomic<unsigned> count = 0;
  char host[256] = "";
  if (gethostname(host, sizeof host - 1) != 0) return false;
  const fs::path temporary = fmt::format("{}.{}.{}.{}.tmp", file.string(), host, getpid(), count++);
  {
    std::ofstream stream(temporary, std::ios::binary | std::ios::trunc);
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (!stream) error = std::make_error_code(std::errc::io_error);
  }
  if (!error) fs::rename(temporary, file, error);
  if (!error) return true;
  std::error_code ignored;  // it may not be there
  fs::remove(temporary, ignored);
  return false;
}

}  // namespace

fs::path CacheFolder() {
  const auto set = [](const char* name) -> std::string_view {
    const char* value = std::getenv(name);
    return value == nullptr ? "" : value;
  };
  if (const auto folder = set("CDB_CACHE"); !folder.empty()) return folder;
  // A relative one is to be ignored, says the XDG base directory specification.
  if (const auto folder = set("XDG_CACHE_HOME"); folder.starts_with('/'))
    return fs::path(folder) / "cdb";
  if (const auto home = set("HOME"); !home.empty()) return fs::path(home) / ".cache" / "cdb";
  return {};
}

std::string CacheKey(const Mesh& mesh, const DecomposeOptions& options) {
  std::string bytes(kMagic);
  bytes += DecomposerVersion();
  bytes += '\n';
  PutWord(options.faces, bytes);
  PutReal(options.concavity, bytes);
  PutReal(options.compacity, bytes);
  PutWord(options.least_pieces, bytes);
  PutWord(options.vertices_per_hull, bytes);
  PutReal(options.least_volume, bytes);
  PutReal(options.good_iou, bytes);
  PutPoints(mesh.vertices, bytes);
  PutWord(mesh.triangles.size(), bytes);
  for (const Triangle& triangle : mesh.triangles)
    for (const std::uint32_t vertex : triangle) PutWord(vertex, bytes);
  return compiler::Sha256Hex(bytes);
}

CachedDecomposition DecomposeOnce(const Mesh& mesh, std::string_view name,
                                  const DecomposeOptions& options, const fs::path& folder) {
  if (folder.empty()) return {Decompose(mesh, name, options), CacheUse::kNotStored};
  const std::string key = CacheKey(mesh, options);
  const fs::path file = folder / (key + ".hulls");
  if (auto found = Find(file, key)) return {*std::move(found), CacheUse::kFound};
  Decomposition decomposition = Decompose(mesh, name, options);
  const bool is_stored = Store(ToBytes(decomposition, key), file);
  return {std::move(decomposition), is_stored ? CacheUse::kStored : CacheUse::kNotStored};
}

}  // namespace cdb::library
