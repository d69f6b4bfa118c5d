#include "runtime/results/journal/record.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <type_traits>
#include <utility>

#include "runtime/protocol/verdict.h"
#include "runtime/results/hdf5/filters.h"

namespace cdb::journal {
namespace {

class Writer {
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
  void Add(const Record::Chunk& chunk) {
    Add(chunk.array);
    Add(chunk.index);
    Add(chunk.bytes);
  }
  void Add(const RecordedArray& array) {
    Add(array.name);
    Add(static_cast<std::int8_t>(array.type));
    AddList(array.shape);
    AddList(array.chunk);
  }
  template <typename Item>
  void AddList(const std::vector<Item>& items) {
    Add(std::uint64_t{items.size()});
    for (const Item& item : items) Add(item);
  }
  /// Compressed, after its length.
  std::vector<std::byte> Finish() const {
    const std::uint64_t size = bytes_.size();
    std::vector<std::byte> all(sizeof size);
    std::memcpy(all.data(), &size, sizeof size);
    const std::vector<std::byte> packed = hdf5::Deflated(bytes_);
    all.insert(all.end(), packed.begin(), packed.end());
    return all;
  }

 private:
  std::vector<std::byte> bytes_;
};

[[noreturn]] void FailEnd() { throw hdf5::Error("its facts are cut short"); }

/// Throws Error if the bytes end before a value.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> stored) {
    constexpr std::uint64_t kMost = std::uint64_t{1} << 32;
    std::uint64_t size = 0;
    if (stored.size() < sizeof size) FailEnd();
    std::memcpy(&size, stored.data(), sizeof size);
    if (size > kMost) FailEnd();
    bytes_ = hdf5::Inflated(stored.subspan(sizeof size), size);
    left_ = bytes_;
  }
  template <typename Number>
  requires std::is_arithmetic_v<Number>
  void Read(Number& number) {
    if (left_.size() < sizeof number) FailEnd();
    std::memcpy(&number, left_.data(), sizeof number);
    left_ = left_.subspan(sizeof number);
  }
  void Read(std::string& text) {
    const std::uint64_t size = ReadCount();
    text.assign(reinterpret_cast<const char*>(left_.data()), size);
    left_ = left_.subspan(size);
  }
  void Read(Record::Chunk& chunk) {
    Read(chunk.array);
    Read(chunk.index);
    Read(chunk.bytes);
  }
  void Read(RecordedArray& array) {
    std::int8_t type = 0;
    Read(array.name);
    Read(type);
    if (type < 0 || type > static_cast<std::int8_t>(hdf5::Type::kText)) FailEnd();
    array.type = static_cast<hdf5::Type>(type);
    ReadList(array.shape);
    ReadList(array.chunk);
  }
  template <typename Item>
  void ReadList(std::vector<Item>& items) {
    items.resize(ReadCount());
    for (Item& item : items) Read(item);
  }
  /// A length. Each item takes at least one byte.
  std::uint64_t ReadCount() {
    std::uint64_t count = 0;
    Read(count);
    if (count > left_.size()) FailEnd();
    return count;
  }
  void Finish() const {
    if (!left_.empty()) throw hdf5::Error("its facts have a tail");
  }

 private:
  std::vector<std::byte> bytes_;
  std::span<const std::byte> left_;
};

}  // namespace

std::vector<std::byte> About::Encode() const {
  Writer writer;
  writer.AddList(arrays);
  writer.AddList(numbers);
  writer.AddList(texts);
  writer.Add(std::uint64_t{provenance.size()});
  for (const auto& [name, text] : provenance) {
    writer.Add(name);
    writer.Add(text);
  }
  return writer.Finish();
}

About About::Decode(std::span<const std::byte> bytes) {
  Reader reader(bytes);
  About about;
  reader.ReadList(about.arrays);
  reader.ReadList(about.numbers);
  reader.ReadList(about.texts);
  const std::uint64_t count = reader.ReadCount();
  for (std::uint64_t i = 0; i < count; ++i) {
    std::string name, text;
    reader.Read(name);
    reader.Read(text);
    about.provenance.emplace(std::move(name), std::move(text));
  }
  reader.Finish();
  return about;
}

std::vector<std::byte> Record::EncodeFacts() const {
  Writer writer;
  writer.AddList(numbers);
  writer.AddList(texts);
  writer.AddList(chunks);
  return writer.Finish();
}

void Record::DecodeFacts(std::span<const std::byte> facts) {
  Reader reader(facts);
  reader.ReadList(numbers);
  reader.ReadList(texts);
  reader.ReadList(chunks);
  reader.Finish();
  std::uint64_t left = bytes.size();
  for (const Chunk& chunk : chunks) {
    if (chunk.array >= about->arrays.size() || chunk.bytes > left)
      throw hdf5::Error("it lists chunks that it does not hold");
    left -= chunk.bytes;
  }
  if (left != 0 || numbers.size() != about->numbers.size() || texts.size() != about->texts.size())
    throw hdf5::Error("its facts do not fit together");
}

std::optional<double> Record::Number(std::string_view name) const {
  const auto found = std::ranges::find(about->numbers, name);
  if (found == about->numbers.end()) return std::nullopt;
  return numbers[static_cast<std::size_t>(found - about->numbers.begin())];
}

std::string Record::Text(std::string_view name) const {
  const auto found = std::ranges::find(about->texts, name);
  if (found == about->texts.end()) return {};
  return texts[static_cast<std::size_t>(found - about->texts.begin())];
}

void Record::Add(std::uint32_t array, std::uint32_t index, std::span<const std::byte> filtered) {
  chunks.push_back({array, index, filtered.size()});
  bytes.insert(bytes.end(), filtered.begin(), filtered.end());
}

RunInfo InfoOf(const Record& record) {
  const double status = record.Number("status").value_or(0);
  // A reference run has no timings that a verdict could void.
  const double verdict = record.Number("verdict").value_or(0);
  if (!(status > 0 && status < static_cast<double>(std::size(results::kStatusNames))) ||
      !(verdict >= 0 && verdict < static_cast<double>(protocol::Verdicts().size())))
    throw hdf5::Error("it has a status or a verdict that this cdb does not know");
  return {record.run_id,
          {static_cast<results::Status>(status), static_cast<protocol::Verdict>(verdict)},
          record.Text("run/omitted"),
          record.Text("run/needs"),
          record.Number("run/noise") == static_cast<double>(machine::Noise::kNoisy)};
}

}  // namespace cdb::journal
