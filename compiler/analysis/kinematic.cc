#include "compiler/analysis/kinematic.h"

#include <algorithm>

namespace cdb::analysis {
namespace {

bool MayBeKinematic(const schema::Value& mass) {
  if (const schema::Word* word = schema::AsWord(mass)) return word->text == kKinematicWord;
  const schema::Distribution* drawn = schema::AsDistribution(mass);
  return drawn != nullptr && std::ranges::any_of(drawn->arguments, MayBeKinematic);
}

}  // namespace

bool HasKinematic(const plan::Group& group) {
  return group.settings.Count("quantity") > 0 && MayBeKinematic(group.settings.Get("mass"));
}

}  // namespace cdb::analysis
