#include "library/meshes/hull_cache.h"

#include <bit>
#include <optional>

namespace cdb::library {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kKind = "hulls";

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

std::string ToBytes(const Decomposition& decomposition) {
  std::string bytes;
  PutReal(decomposition.volume_error, bytes);
  PutReal(decomposition.iou, bytes);
  PutWord(decomposition.hulls.size(), bytes);
  for (const Hull& hull : decomposition.hulls) PutPoints(hull.vertices, bytes);
  return bytes;
}

std::optional<Decomposition> FromBytes(std::string_view bytes) {
  // It is what ToBytes wrote; the bounds guard against our own mistakes.
  Reader reader(bytes);
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

}  // namespace

std::string CacheKey(const Mesh& mesh, const DecomposeOptions& options) {
  std::string bytes = DecomposerVersion();
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
  return CacheKeyOf(bytes);
}

CachedDecomposition DecomposeOnce(const Mesh& mesh, std::string_view name,
                                  const DecomposeOptions& options, const fs::path& folder) {
  const std::string key = CacheKey(mesh, options);
  if (const auto bytes = FindCached(folder, kKind, key))
    if (auto found = FromBytes(*bytes)) return {*std::move(found), CacheUse::kFound};
  Decomposition decomposition = Decompose(mesh, name, options);
  const bool is_stored = StoreCached(folder, kKind, key, ToBytes(decomposition));
  return {std::move(decomposition), is_stored ? CacheUse::kStored : CacheUse::kNotStored};
}

}  // namespace cdb::library
