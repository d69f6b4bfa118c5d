// A buffer of pairs that is kept from cycle to cycle and does not initialise its elements, unlike a
// vector.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>

#include "library/detectors/kernels/kernels.h"

namespace cdb::kernels {

/// Pairs in the order in which kernels write them. Errors: bad_alloc. Threads: one at a time.
class PairBuffer {
 public:
  PairBuffer() { Clear(); }
  PairBuffer(const PairBuffer&) = delete;
  PairBuffer& operator=(const PairBuffer&) = delete;

  void Clear() {
    sink_.owner = this;
    sink_.out = {pairs_.get(), pairs_.get() + capacity_, Grow};
  }
  /// Makes room for `capacity` pairs; only while it is empty.
  void Reserve(std::size_t capacity) {
    if (capacity <= capacity_) return;
    capacity_ = capacity;
    pairs_ = std::make_unique_for_overwrite<Pair[]>(capacity_);
    Clear();
  }
  PairSink& sink() { return sink_.out; }
  std::size_t size() const { return static_cast<std::size_t>(sink_.out.at - pairs_.get()); }
  std::span<Pair> pairs() { return {pairs_.get(), size()}; }
  void Add(const Pair& pair) {
    if (sink_.out.at == sink_.out.end) Enlarge();
    *sink_.out.at++ = pair;
  }
  void Append(std::span<const Pair> pairs) {
    while (capacity_ - size() < pairs.size()) Enlarge();
    sink_.out.at = std::ranges::copy(pairs, sink_.out.at).out;
  }
  /// Keeps the first `size`.
  void Cut(std::size_t size) { sink_.out.at = pairs_.get() + size; }

 private:
  struct Owned {
    PairSink out;
    PairBuffer* owner;
  };
  static void Grow(PairSink& sink) {
    static_assert(offsetof(Owned, out) == 0);
    reinterpret_cast<Owned&>(sink).owner->Enlarge();
  }
  void Enlarge() {
    const std::size_t used = size();
    capacity_ = std::max<std::size_t>(2 * capacity_, 1024);
    auto larger = std::make_unique_for_overwrite<Pair[]>(capacity_);
    std::copy_n(pairs_.get(), used, larger.get());
    pairs_ = std::move(larger);
    sink_.out.at = pairs_.get() + used;
    sink_.out.end = pairs_.get() + capacity_;
  }

  std::unique_ptr<Pair[]> pairs_;
  std::size_t capacity_ = 0;
  Owned sink_;
};

}  // namespace cdb::kernels
