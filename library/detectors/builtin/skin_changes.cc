#include "library/detectors/builtin/skin_changes.h"

#include <algorithm>
#include <cstring>
#include <iterator>

namespace cdb::builtin {

void SkinChanges::Forget() {
  knows_last_ = has_flags_ = false;
  replaced_.clear();
  rest_.clear();
}

void SkinChanges::Replace(std::span<const Pair> candidates) {
  if (!has_flags_) return;
  has_flags_ = false;
  for (std::size_t i = 0; i < met_.size(); ++i)
    if (met_[i] != 0) replaced_.push_back(candidates[i]);
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
  met_.resize(size, 0);
  parts_.Run(size / 16, [&](std::size_t part, std::size_t parts, kernels::PairBuffer& found) {
    const std::size_t begin = size * part / parts, end = size * (part + 1) / parts;
    kernels.find_changed(scene.boxes.data(), candidates.data() + begin, met_.data() + begin,
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
