// A search for pairs in parts, which the threads share.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "library/detectors/kernels/pair_buffer.h"
#include "library/detectors/kernels/thread_pool.h"

namespace cdb::kernels {

/// One buffer for each part; their concatenation is the list. Work is given in nanoseconds, as a
/// cost model estimates it: what is too short is done by the caller. Errors: what a part throws.
/// Threads: one caller.
class PairParts {
 public:
  explicit PairParts(unsigned threads) : pool_(std::max(threads, 1u)) {
    const unsigned parts = pool_.size() == 1 ? 1 : kPartsOfThread * pool_.size();
    for (unsigned part = 0; part < parts; ++part)
      buffers_.push_back(std::make_unique<PairBuffer>());
  }

  /// Calls find(part, parts, buffer) for all parts, each with an empty buffer.
  template <typename Find>
  void Run(double work, const Find& find) {
    for (auto& buffer : buffers_) buffer->Clear();
    const unsigned parts = PartsOf(work);
    if (parts == 1) return find(0u, 1u, *buffers_[0]);
    pool_.Run(parts, [&](unsigned part) { find(part, parts, *buffers_[part]); });
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
    pool_.Run(parts, [&](unsigned part) {
      const std::size_t from = begin + blocks * part / parts * block;
      const std::size_t to = begin + blocks * (part + 1) / parts * block;
      run(part, std::min(from, end), std::min(to, end));
    });
    return parts;
  }
  /// Begins a cycle, which lasts as long as what is returned. Its work decides whether threads that
  /// are asleep are woken.
  [[nodiscard]] ThreadPool::Session Begin(double work) { return {pool_, work >= kWorthWaking}; }
  /// The most parts of a search.
  std::size_t most() const { return buffers_.size(); }
  ThreadPool& pool() { return pool_; }
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
    if (buffers_.size() == 1 || pool_.IsResting()) return 1;
    if (work < kWorthWaking && !pool_.IsAwake()) return 1;
    return static_cast<unsigned>(
        std::clamp(work / kLeastPart, 1., static_cast<double>(buffers_.size())));
  }

  ThreadPool pool_;
  std::vector<std::unique_ptr<PairBuffer>> buffers_;
};

}  // namespace cdb::kernels
