// A search for pairs in parts, one for each thread.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "library/detectors/kernels/pair_buffer.h"
#include "library/detectors/kernels/thread_pool.h"

namespace cdb::kernels {

/// One buffer for each part; their concatenation is the list. Errors: what a part throws.
/// Threads: one caller.
class PairParts {
 public:
  explicit PairParts(unsigned threads) : pool_(std::max(threads, 1u)) {
    for (unsigned part = 0; part < pool_.size(); ++part)
      buffers_.push_back(std::make_unique<PairBuffer>());
  }

  /// Calls find(part, parts, buffer) for all parts, each with an empty buffer: on all threads if
  /// `size` bodies or pairs are enough work, otherwise as one part.
  template <typename Find>
  void Run(std::size_t size, const Find& find) {
    for (auto& buffer : buffers_) buffer->Clear();
    if (size < kWorthWaking)
      find(0u, 1u, *buffers_[0]);
    else
      pool_.Run([&](unsigned part) { find(part, pool_.size(), *buffers_[part]); });
  }
  /// Calls run(from, to) for adjacent ranges that cover `begin` to `end`, and start at multiples of
  /// `block` if `begin` is one: on all threads if there are enough bodies.
  template <typename Work>
  void ForEach(std::size_t begin, std::size_t end, std::size_t block, const Work& run) {
    if (end - begin < kWorthWaking || pool_.size() == 1) return run(begin, end);
    const std::size_t blocks = (end - begin + block - 1) / block;
    pool_.Run([&](unsigned part) {
      const std::size_t from = begin + blocks * part / pool_.size() * block;
      const std::size_t to = begin + blocks * (part + 1) / pool_.size() * block;
      run(from, std::min(to, end));
    });
  }
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
  /// Waking a thread costs as much as a few hundred bodies.
  static constexpr std::size_t kWorthWaking = 1500;

  ThreadPool pool_;
  std::vector<std::unique_ptr<PairBuffer>> buffers_;
};

}  // namespace cdb::kernels
