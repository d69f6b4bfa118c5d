#include "runtime/store/shards/shard_index.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cstring>
#include <iterator>
#include <type_traits>

#include "runtime/store/files/safe_file.h"
#include "runtime/store/files/seal.h"
#include "runtime/store/versions.h"

namespace cdb::shards {
namespace {

/// The end of the index.
struct IndexEnd {
  std::uint64_t bytes;  ///< of the index, before this
  std::array<char, 8> magic;
};
static_assert(sizeof(IndexEnd) == 16);
/// Changes with the format.
constexpr std::array<char, 8> kIndexMagic = {'c', 'd', 'b', ' ', 'i', 'd', 'x', '1'};

class IndexWriter {
 public:
  template <typename Number>
  requires std::is_arithmetic_v<Number>
  void Add(Number number) {
    const auto bytes = std::as_bytes(std::span(&number, 1));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  void Add(const std::string& text) {
    Add(std::uint64_t{text.size()});
    const auto bytes = std::as_bytes(std::span(text));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  std::vector<std::byte> Finish() {
    const IndexEnd end = {bytes_.size(), kIndexMagic};
    const auto bytes = std::as_bytes(std::span(&end, 1));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return std::move(bytes_);
  }

 private:
  std::vector<std::byte> bytes_;
};

/// Each call returns false if the bytes end before the value.
class IndexReader {
 public:
  explicit IndexReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <typename Number>
  requires std::is_arithmetic_v<Number>
  bool Read(Number& number) {
    if (bytes_.size() < sizeof(number)) return false;
    std::memcpy(&number, bytes_.data(), sizeof(number));
    bytes_ = bytes_.subspan(sizeof(number));
    return true;
  }
  bool Read(std::string& text) {
    std::uint64_t size = 0;
    if (!Read(size) || size > bytes_.size()) return false;
    text.assign(reinterpret_cast<const char*>(bytes_.data()), size);
    bytes_ = bytes_.subspan(size);
    return true;
  }
  /// The length of a list. Each item takes at least one byte.
  bool ReadCount(std::uint64_t& count) { return Read(count) && count <= bytes_.size(); }
  bool is_at_end() const { return bytes_.empty(); }

 private:
  std::span<const std::byte> bytes_;
};

bool ReadInfo(IndexReader& reader, ShardInfo& info) {
  std::int8_t status = 0, verdict = 0;
  if (!reader.Read(info.run_id) || !reader.Read(info.plan_sha256) || !reader.Read(status) ||
      !reader.Read(verdict) || !reader.Read(info.omitted) || !reader.Read(info.decisions))
    return false;
  if (status < 0 || status >= static_cast<int>(std::size(store::kStatusNames)) || verdict < 0 ||
      verdict >= static_cast<int>(measure::Verdicts().size()))
    return false;
  info.outcome = {static_cast<store::Status>(status), static_cast<measure::Verdict>(verdict)};
  return true;
}

template <typename Item>
bool ReadList(IndexReader& reader, std::vector<Item>& items) {
  std::uint64_t count = 0;
  if (!reader.ReadCount(count)) return false;
  items.resize(count);
  for (Item& item : items)
    if (!reader.Read(item)) return false;
  return true;
}

bool ReadProvenance(IndexReader& reader, store::Provenance& provenance) {
  std::uint64_t count = 0;
  if (!reader.ReadCount(count)) return false;
  for (std::uint64_t i = 0; i < count; ++i) {
    std::string name, text;
    if (!reader.Read(name) || !reader.Read(text)) return false;
    provenance.emplace(std::move(name), std::move(text));
  }
  return true;
}

/// `end`: the end of the HDF5 file.
bool ReadChunks(IndexReader& reader, std::uint64_t end, std::vector<IndexedChunk>& chunks) {
  std::uint64_t count = 0;
  if (!reader.ReadCount(count)) return false;
  chunks.resize(count);
  for (IndexedChunk& chunk : chunks) {
    if (!reader.Read(chunk.series) || !reader.Read(chunk.chunk) ||
        !reader.Read(chunk.filter_mask) || !reader.Read(chunk.begin) || !reader.Read(chunk.bytes))
      return false;
    if (chunk.begin > end || chunk.bytes > end - chunk.begin) return false;
  }
  return true;
}

}  // namespace

std::uint64_t LayoutChecksum(const store::Layout& layout, const store::PlanFacts& facts) {
  std::string text = fmt::format("schema {}, chunks with checksums\n", store::kSchemaVersion);
  for (const store::Array& array : layout.arrays) {
    if (array.series == nullptr) continue;
    const auto inner = std::span(array.shape).subspan(layout.grid.size());
    text += fmt::format("{} {} [{}] [{}]\n", array.name, static_cast<int>(array.type),
                        fmt::join(inner, " "), fmt::join(array.chunk, " "));
  }
  for (const store::RunNumber& number : facts.numbers) text += number.name + "\n";
  for (const store::RunText& fact : facts.texts) text += fact.name + "\n";
  return files::Checksum(std::as_bytes(std::span(text)));
}

std::vector<std::byte> IndexBytes(const ShardIndex& index) {
  IndexWriter writer;
  writer.Add(index.layout);
  writer.Add(index.info.run_id);
  writer.Add(index.info.plan_sha256);
  writer.Add(static_cast<std::int8_t>(index.info.outcome.status));
  writer.Add(static_cast<std::int8_t>(index.info.outcome.verdict));
  writer.Add(index.info.omitted);
  writer.Add(index.info.decisions);
  writer.Add(std::uint64_t{index.numbers.size()});
  for (const double number : index.numbers) writer.Add(number);
  writer.Add(std::uint64_t{index.texts.size()});
  for (const std::string& text : index.texts) writer.Add(text);
  writer.Add(std::uint64_t{index.provenance.size()});
  for (const auto& [name, text] : index.provenance) {
    writer.Add(name);
    writer.Add(text);
  }
  writer.Add(std::uint64_t{index.chunks.size()});
  for (const IndexedChunk& chunk : index.chunks) {
    writer.Add(chunk.series);
    writer.Add(chunk.chunk);
    writer.Add(chunk.filter_mask);
    writer.Add(chunk.begin);
    writer.Add(chunk.bytes);
  }
  return writer.Finish();
}

std::optional<ShardIndex> FindIndex(std::span<const std::byte> shard) {
  IndexEnd end = {};
  if (shard.size() < sizeof(end)) return std::nullopt;
  std::memcpy(&end, &shard[shard.size() - sizeof(end)], sizeof(end));
  const std::uint64_t before = shard.size() - sizeof(end);
  if (end.magic != kIndexMagic || end.bytes > before) return std::nullopt;
  const std::uint64_t begin = before - end.bytes;
  IndexReader reader(shard.subspan(begin, end.bytes));
  ShardIndex index;
  if (!reader.Read(index.layout) || !ReadInfo(reader, index.info) ||
      !ReadList(reader, index.numbers) || !ReadList(reader, index.texts) ||
      !ReadProvenance(reader, index.provenance) || !ReadChunks(reader, begin, index.chunks) ||
      !reader.is_at_end())
    return std::nullopt;
  return index;
}

}  // namespace cdb::shards
