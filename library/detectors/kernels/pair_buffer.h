// A buffer of pairs that is kept from cycle to cycle and does not initialise its elements, unlike a
// vector.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "library/detectors/kernels/kernels.h"
#include "library/detectors/kernels/thread_pool.h"

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

// A search for pairs in parts, which the threads share.

/// One buffer for each part; their concatenation is the list. Work is given in nanoseconds, as a
/// cost model estimates it: what is too short is done by the caller. Errors: what a part throws.
/// Threads: one caller.
class PairParts {
 public:
  explicit PairParts(unsigned threads) : pool_(ThreadPool::Shared(std::max(threads, 1u))) {
    const unsigned parts = pool_->size() == 1 ? 1 : kPartsOfThread * pool_->size();
    for (unsigned part = 0; part < parts; ++part)
      buffers_.push_back(std::make_unique<PairBuffer>());
  }

  /// Calls find(part, parts, buffer) for all parts, each with an empty buffer.
  template <typename Find>
  void Run(double work, const Find& find) {
    for (auto& buffer : buffers_) buffer->Clear();
    const unsigned parts = PartsOf(work);
    if (parts == 1) return find(0u, 1u, *buffers_[0]);
    pool_->Run(parts, [&](unsigned part) { find(part, parts, *buffers_[part]); });
  }
  /// Calls run(part, from, to) for adjacent ranges that cover `begin` to `end`, and start at
  /// multiples of `block` if `begin` is one. Returns the number of parts.
  template <typename Work>
  unsigned ForEach(double work, std::size_t begin, std::size_t end, std::size_t block,
                   const Work& run) {
    const unsigned parts = PartsOf(work);
    if (parts == 1) {
      run(0u, begin, end);
      return 1;
    }
    const std::size_t blocks = (end - begin + block - 1) / block;
    pool_->Run(parts, [&](unsigned part) {
      const std::size_t from = begin + blocks * part / parts * block;
      const std::size_t to = begin + blocks * (part + 1) / parts * block;
      run(part, std::min(from, end), std::min(to, end));
    });
    return parts;
  }
  /// Begins a cycle, which lasts as long as what is returned. Its work decides whether threads that
  /// are asleep are woken.
  [[nodiscard]] ThreadPool::Session Begin(double work) { return {*pool_, work >= kWorthWaking}; }
  /// The most parts of a search.
  std::size_t most() const { return buffers_.size(); }
  ThreadPool& pool() { return *pool_; }
  PairBuffer& last() { return *buffers_.back(); }
  std::size_t size() const {
    std::size_t size = 0;
    for (const auto& buffer : buffers_) size += buffer->size();
    return size;
  }
  void AppendTo(PairBuffer& pairs) {
    for (auto& buffer : buffers_) pairs.Append(buffer->pairs());
  }
  void AppendTo(std::vector<Pair>& pairs) {
    pairs.reserve(pairs.size() + size());
    for (auto& buffer : buffers_)
      pairs.insert(pairs.end(), buffer->pairs().begin(), buffer->pairs().end());
  }

 private:
  /// The more parts, the less a thread waits for another that was interrupted or woke up late.
  static constexpr unsigned kPartsOfThread = 4;
  /// The shortest part, because sharing it costs some 200 ns; and the work for which a sleeping
  /// thread is woken.
  static constexpr double kLeastPart = 2000, kWorthWaking = 100'000;

  unsigned PartsOf(double work) const {
    if (buffers_.size() == 1 || pool_->IsResting()) return 1;
    if (work < kWorthWaking && !pool_->IsAwake()) return 1;
    return static_cast<unsigned>(
        std::clamp(work / kLeastPart, 1., static_cast<double>(buffers_.size())));
  }

  std::shared_ptr<ThreadPool> pool_;
  std::vector<std::unique_ptr<PairBuffer>> buffers_;
};

}  // namespace cdb::kernels
