#include "runtime/store/hdf5/object_header.h"

#include <algorithm>
#include <string>

#include "runtime/store/hdf5/bytes.h"
#include "runtime/store/hdf5/object.h"

namespace cdb::hdf5 {
namespace {

constexpr std::string_view kHeaderSignature("OHDR\2", 5), kMoreSignature("OCHK", 4);
constexpr std::uint64_t kChecksumBytes = 4;
constexpr std::uint8_t kLayoutMessage = 8, kAttributeMessage = 12, kMoreMessage = 16;
/// Flags of a header.
constexpr std::uint8_t kSizeBits = 3, kHasOrder = 1 << 2, kHasLimits = 1 << 4, kHasTimes = 1 << 5;

[[noreturn]] void RefuseHeader() { throw Error("an object with another header"); }

}  // namespace

ObjectHeader::ObjectHeader(std::span<const std::byte> image, std::uint64_t address)
    : image_(image) {
  const Extent rest = {address, image.size() - std::min<std::uint64_t>(address, image.size())};
  const auto flags = At<std::uint8_t>(rest, kHeaderSignature.size());
  if (!AsText(image.subspan(address)).starts_with(kHeaderSignature)) RefuseHeader();
  std::uint64_t at = kHeaderSignature.size() + 1;
  if ((flags & kHasTimes) != 0) at += 16;
  if ((flags & kHasLimits) != 0) at += 4;
  const int size_bytes = 1 << (flags & kSizeBits);
  std::uint64_t bytes = 0;
  for (int i = 0; i < size_bytes; ++i)
    bytes |= std::uint64_t{At<std::uint8_t>(rest, at++)} << (8 * i);
  has_order_ = (flags & kHasOrder) != 0;
  if (bytes > rest.bytes - at || kChecksumBytes > rest.bytes - at - bytes) RefuseHeader();
  blocks_.push_back({address, at + bytes + kChecksumBytes});
  ReadMessages({address + at, bytes});
}

template <typename Number>
Number ObjectHeader::At(const Extent& within, std::uint64_t offset) const {
  if (within.bytes < sizeof(Number) || offset > within.bytes - sizeof(Number)) RefuseHeader();
  return Get<Number>(image_, within.begin + offset);
}

void ObjectHeader::ReadMessages(Extent messages) {
  constexpr std::size_t kMostBlocks = 64;
  const std::uint64_t head = has_order_ ? 6 : 4;
  // Fewer bytes than a head are a gap.
  while (messages.bytes >= head) {
    const auto type = At<std::uint8_t>(messages, 0);
    const std::uint64_t bytes = At<std::uint16_t>(messages, 1);
    if (bytes > messages.bytes - head) RefuseHeader();
    const Extent body = {messages.begin + head, bytes};
    messages = {body.begin + bytes, messages.bytes - head - bytes};
    if (type != kMoreMessage) {
      messages_.push_back({type, body});
      continue;
    }
    const Extent more = {At<std::uint64_t>(body, 0), At<std::uint64_t>(body, 8)};
    const std::uint64_t around = kMoreSignature.size() + kChecksumBytes;
    if (more.begin > image_.size() || more.bytes > image_.size() - more.begin ||
        more.bytes < around || blocks_.size() >= kMostBlocks ||
        !AsText(image_.subspan(more.begin)).starts_with(kMoreSignature))
      RefuseHeader();
    blocks_.push_back(more);
    ReadMessages({more.begin + kMoreSignature.size(), more.bytes - around});
  }
}

const Extent& ObjectHeader::Layout() const {
  const auto found = std::ranges::find(messages_, kLayoutMessage, &Message::type);
  if (found == messages_.end()) RefuseHeader();
  return found->body;
}

Extent ObjectHeader::CompactValues() const {
  constexpr std::uint8_t kCompact = 0;
  const Extent& layout = Layout();
  const auto version = At<std::uint8_t>(layout, 0);
  if ((version != 3 && version != 4) || At<std::uint8_t>(layout, 1) != kCompact) RefuseHeader();
  const Extent values = {layout.begin + 4, At<std::uint16_t>(layout, 2)};
  if (values.bytes > layout.bytes - 4) RefuseHeader();
  return values;
}

std::uint64_t ObjectHeader::SingleChunk() const {
  constexpr std::uint8_t kChunked = 2, kHasFilters = 1 << 1, kSingle = 1;
  const Extent& layout = Layout();
  if (At<std::uint8_t>(layout, 0) != 4 || At<std::uint8_t>(layout, 1) != kChunked ||
      (At<std::uint8_t>(layout, 2) & kHasFilters) == 0)
    RefuseHeader();
  const std::uint64_t rank = At<std::uint8_t>(layout, 3), dimension = At<std::uint8_t>(layout, 4);
  const std::uint64_t at = 5 + rank * dimension;
  if (At<std::uint8_t>(layout, at) != kSingle) RefuseHeader();
  At<std::uint64_t>(layout, at + 1 + 8 + 4);  // the address
  return layout.begin + at + 1;
}

Extent ObjectHeader::Attribute(std::string_view name) const {
  constexpr std::uint64_t kHead = 9;
  for (const auto& [type, body] : messages_) {
    if (type != kAttributeMessage) continue;
    const auto bytes = [&](std::uint64_t at) { return std::uint64_t{At<std::uint16_t>(body, at)}; };
    // The name, with its NUL, and the descriptions of type and space precede the value.
    const std::uint64_t before = kHead + bytes(2) + bytes(4) + bytes(6);
    if (At<std::uint8_t>(body, 0) != 3 || before > body.bytes || bytes(2) == 0) RefuseHeader();
    if (AsText(image_.subspan(body.begin + kHead, bytes(2) - 1)) == name)
      return {body.begin + before, body.bytes - before};
  }
  RefuseHeader();
}

}  // namespace cdb::hdf5
