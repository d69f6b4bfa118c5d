// Disjoint sets of numbers.
//
// Each set's root is its smallest number, so that the order of joins does not matter. Threads: an
// object is used by one. Source: Tarjan & van Leeuwen, "Worst-case analysis of set union
// algorithms", J. ACM 31(2), 1984.
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace cdb::meshes {

class UnionFind {
 public:
  explicit UnionFind(std::size_t count) { Reset(count); }
  void Reset(std::size_t count) {
    parent_.resize(count);
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  std::uint32_t Root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void Join(std::uint32_t a, std::uint32_t b) {
    a = Root(a);
    b = Root(b);
    if (a > b) std::swap(a, b);
    parent_[b] = a;
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace cdb::meshes
