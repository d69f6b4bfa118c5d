#include "library/objects/decomposition_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace cdb::objects {
namespace {

constexpr std::string_view kKind = "form";
/// To be incremented with changes that affect a form but are not part of DecomposerVersion: reading
/// and closing of files, mass properties, the torus, and the storage format.
constexpr int kVersion = 1;

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
  archive.Real(form.volume);
  reals(form.centre);
  reals(form.second_moments);
  archive.Real(form.volume_error);
  archive.Real(form.iou);
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
