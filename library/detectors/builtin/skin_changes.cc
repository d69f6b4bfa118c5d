#include "library/detectors/builtin/skin_changes.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <iterator>

#include "library/detectors/builtin/skin_costs.h"

namespace cdb::builtin {

using kernels::kMetBits;

void SkinChanges::Forget() {
  knows_last_ = has_flags_ = false;
  awake_.Forget();
  replaced_.clear();
  rest_.clear();
}

void SkinChanges::Replace(std::span<const Pair> candidates) {
  if (!has_flags_) return;
  has_flags_ = false;
  awake_.ForgetIndex();
  for (std::size_t word = 0; word < met_.size(); ++word)
    for (std::uint64_t bits = met_[word]; bits != 0; bits &= bits - 1)
      replaced_.push_back(
          candidates[word * kMetBits + static_cast<std::size_t>(std::countr_zero(bits))]);
}

bool SkinChanges::Find(const Scene& scene, const kernels::Kernels& kernels,
                       std::span<const Pair> candidates, std::span<const Pair> rest,
                       std::vector<Pair>& came, std::vector<Pair>& went) {
  const bool had_flags = has_flags_;
  if (!had_flags) {
    met_.clear();
    met_count_ = 0;
    has_flags_ = true;
  }
  met_.resize((candidates.size() + kMetBits - 1) / kMetBits, 0);
  changed_.clear();
  if (had_flags && awake_.UpdateIndex(scene, candidates))
    FindAwake(scene, candidates);
  else
    FindAll(scene, kernels, candidates);
  awake_.Tested();
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

void SkinChanges::FindAll(const Scene& scene, const kernels::Kernels& kernels,
                          std::span<const Pair> candidates) {
  const std::size_t size = candidates.size();
  parts_.Run(kTestCost * static_cast<double>(size),
             [&](std::size_t part, std::size_t parts, kernels::PairBuffer& found) {
               const std::size_t first = met_.size() * part / parts, begin = first * kMetBits;
               const std::size_t end = std::min(size, met_.size() * (part + 1) / parts * kMetBits);
               kernels.find_changed(scene.boxes.data(), candidates.data() + begin,
                                    met_.data() + first, end - begin, found.sink());
             });
  parts_.AppendTo(changed_);
}

void SkinChanges::FindAwake(const Scene& scene, std::span<const Pair> candidates) {
  awake_.ForEach(candidates, [&](std::size_t i) {
    const Pair& pair = candidates[i];
    const std::uint64_t bit = std::uint64_t{1} << i % kMetBits;
    if (Overlap(scene.boxes[pair.a], scene.boxes[pair.b]) == ((met_[i / kMetBits] & bit) != 0))
      return;
    met_[i / kMetBits] ^= bit;
    changed_.push_back(pair);
  });
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
