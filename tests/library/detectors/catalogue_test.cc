#include "library/catalogue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>

#include "library/detectors/own.h"

namespace cdb::library {
namespace {

TEST(Catalogue, EveryFamilyOfThePaperHasADetectorOrAReason) {
  for (const FamilyInfo& family : Families()) {
    const bool is_there = std::ranges::any_of(Detectors(), [&](const DetectorInfo& detector) {
      return detector.family.find(family.name) != std::string_view::npos;
    });
    EXPECT_NE(is_there, !family.why_not.empty()) << family.name;
  }
}

TEST(Catalogue, EveryDetectorHasALineASourceAFamilyAndAPart) {
  for (const DetectorInfo& detector : Detectors()) {
    EXPECT_FALSE(detector.doc.empty() || detector.source.empty() || detector.family.empty())
        << detector.name;
    EXPECT_TRUE(detector.HasPhase("broad") || detector.HasPhase("narrow")) << detector.name;
    EXPECT_EQ(detector.part.empty(), FindDetectorPart(detector.part) == nullptr) << detector.name;
  }
}

TEST(Catalogue, OwnDetectorsAreThoseItSaysAreOfCdb) {
  for (const DetectorEntry& entry : OwnDetectors()) {
    const DetectorInfo* info = FindDetector(entry.name);
    ASSERT_NE(info, nullptr) << entry.name;
    EXPECT_EQ(info->source, "cdb") << entry.name;
    EXPECT_EQ(info->HasPhase("broad"), (entry.phases & kBroad) != 0) << entry.name;
    EXPECT_EQ(info->HasPhase("narrow"), (entry.phases & kNarrow) != 0) << entry.name;
  }
  for (const DetectorInfo& info : Detectors())
    EXPECT_EQ(info.source == "cdb", std::ranges::any_of(OwnDetectors(),
                                                        [&](const DetectorEntry& entry) {
                                                          return info.name == entry.name;
                                                        }))
        << info.name;
}

}  // namespace
}  // namespace cdb::library
