#include "compiler/schema/catalogue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>

namespace cdb::tests {
namespace {

TEST(Catalogue, EveryFamilyOfThePaperHasADetectorOrAReason) {
  for (const schema::FamilyInfo& family : schema::Families()) {
    const bool is_there =
        std::ranges::any_of(schema::Detectors(), [&](const schema::DetectorInfo& detector) {
          return detector.family.find(family.name) != std::string_view::npos;
        });
    EXPECT_NE(is_there, !family.why_not.empty()) << family.name;
  }
}

TEST(Catalogue, EveryDetectorHasALineASourceAFamilyAndAPart) {
  for (const schema::DetectorInfo& detector : schema::Detectors()) {
    EXPECT_FALSE(detector.doc.empty() || detector.source.empty() || detector.family.empty())
        << detector.name;
    EXPECT_TRUE(detector.HasPhase("broad") || detector.HasPhase("narrow")) << detector.name;
    EXPECT_EQ(detector.part.empty(), schema::FindDetectorPart(detector.part) == nullptr)
        << detector.name;
  }
}

}  // namespace
}  // namespace cdb::tests
