#include "library/detectors/builtin/skin_changes.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <iterator>

namespace cdb::builtin {
namespace {

constexpr std::size_t kWord = 64;  ///< flags in an element

}  // namespace

void SkinChanges::Forget() {
  knows_last_ = has_flags_ = false;
  replaced_.clear();
  rest_.clear();
}

void SkinChanges::Replace(std::span<const Pair> candidates) {
  if (!has_flags_) return;
  has_flags_ = false;
  for (std::size_t word = 0; word < met_.size(); ++word)
    for (std::uint64_t bits = met_[word]; bits != 0; bits &= bits - 1)
      replaced_.push_back(
          candidates[word * kWord + static_cast<std::size_t>(std::countr_zero(bits))]);
}

bool SkinChanges::Find(const Scene& scene, const kernels::Kernels& kernels,
                       std::span<const Pair> candidates, std::span<const Pair> rest,
                       std::vector<Pair>& came, std::vector<Pair>& went) {
  const std::size_t size = candidates.size();
  if (!has_flags_) {
    met_.clear();
    met_count_ = 0;
    has_flags_ = true;
  }
  const std::size_t words = (size + kWord - 1) / kWord;
  met_.resize(words, 0);
  parts_.Run(size / 16, [&](std::size_t part, std::size_t parts, kernels::PairBuffer& found) {
    const std::size_t first = words * part / parts, begin = first * kWord;
    const std::size_t end = std::min(size, words * (part + 1) / parts * kWord);
    kernels.find_changed(scene.boxes.data(), candidates.data() + begin, met_.data() + first,
                         end - begin, found.sink());
  });
  changed_.clear();
  parts_.AppendTo(changed_);
  const auto overlaps = [&](const Pair& pair) {
    return Overlap(scene.boxes[pair.a], scene.boxes[pair.b]);
  };
  for (const Pair& pair : changed_) (overlaps(pair) ? came : went).push_back(pair);
  met_count_ = met_count_ + came.size() - went.size();
  for (const Pair& pair : replaced_)
    if (!overlaps(pair)) went.push_back(pair);
  replaced_.clear();
  FindRest(scene, rest, came, went);
  const bool did_know = knows_last_;
  knows_last_ = true;
  return did_know;
}

void SkinChanges::FindRest(const Scene& scene, std::span<const Pair> rest, std::vector<Pair>& came,
                           std::vector<Pair>& went) {
  if (rest.size() == rest_.size() &&
      (rest.empty() || std::memcmp(rest.data(), rest_.data(), rest.size_bytes()) == 0))
    return;
  const auto [is, was] = std::ranges::mismatch(rest, rest_);
  came.insert(came.end(), is, rest.end());
  std::copy_if(was, rest_.end(), std::back_inserter(went), [&](const Pair& pair) {
    return !Overlap(scene.boxes[pair.a], scene.boxes[pair.b]);
  });
  rest_.assign(rest.begin(), rest.end());
}

}  // namespace cdb::builtin
