// Damaged files are rejected by name and never crash the reader.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <span>
#include <vector>

#include "runtime/results/files/seal.h"
#include "runtime/results/hdf5/file.h"
#include "runtime/results/store.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using testing::HasSubstr;

/// Three finished runs in a journal, whose bytes are changed.
class Damage : public testing::Test {
 protected:
  Damage() {
    for (const plan::Run& run : plan_.runs)
      WriteRun(plan_, run, FakeResult(run).result, TestProvenance(), folder_.path());
    whole_ = ReadFile(path_);
  }

  /// Expects that a merge refuses the journal by name, or takes each run as it was written or for
  /// missing. Returns true if it was refused.
  bool IsRefused(const std::string& bytes, const std::string& what) {
    SCOPED_TRACE(what);
    for (const char* ending : {"-wal", "-shm"}) std::filesystem::remove(path_.string() + ending);
    WriteFile(path_, bytes);
    try {
      journal::Merge(plan_, {}, folder_.path(), folder_ / "out.h5");
    } catch (const files::StoreError& error) {
      EXPECT_THAT(error.what(), HasSubstr(path_.string()));
      EXPECT_THAT(error.what(), testing::AnyOf(HasSubstr("cdb run"), HasSubstr("--fresh")));
      return true;
    }
    const results::ResultFile file(folder_ / "out.h5");
    for (const plan::Run& run : plan_.runs) {
      const results::ResultFile::Cell cell = {run.at, run.rep};
      if (file.ReadStatus(cell) != results::Status::kMissing) ExpectAsWritten(file, run);
    }
    return false;
  }

  static void ExpectAsWritten(const results::ResultFile& file, const plan::Run& run) {
    const FakeResult fake(run);
    const results::ResultFile::Cell cell = {run.at, run.rep};
    EXPECT_EQ(file.ReadStatus(cell), results::Status::kDone);
    EXPECT_EQ(file.ReadText("host", cell), fake.result.host);
    EXPECT_EQ(file.ReadText("needs", cell), fake.result.decisions);
    EXPECT_EQ(file.ReadReal("peak_rss", cell), fake.result.scalars.peak_rss_bytes);
    const auto steps = file.ReadDuration(protocol::Phase::kStep, cell);
    ASSERT_EQ(steps.size(), 50u);
    for (std::size_t i = 0; i < steps.size(); ++i)
      ASSERT_EQ(steps[i], ValueAt(run, *protocol::FindSeries("duration"),
                                  protocol::IndexOf(protocol::Phase::kStep) * 50 + i));
  }

  const TemporaryFolder folder_;
  const plan::Plan plan_ = MakePlan({NumberAxis("quantity", {10, 20, 30})}, 1, {.cycles = 50});
  const std::filesystem::path path_ = folder_ / "runs.journal";
  std::string whole_;
};

TEST_F(Damage, EveryKindOfTruncation) {
  for (std::size_t n = 1; n < whole_.size(); n += 1 + whole_.size() / Cases(60))
    EXPECT_TRUE(IsRefused(whole_.substr(0, n), "cut to " + std::to_string(n)));
}

TEST_F(Damage, EveryKindOfChangedByte) {
  std::mt19937 random(20260101);
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < 100; ++i) places.push_back(i);
  for (int i = 0; i < Cases(200); ++i) places.push_back(random() % whole_.size());
  int refused = 0;
  for (const std::size_t place : places) {
    std::string bytes = whole_;
    bytes[place] = static_cast<char>(bytes[place] ^ (1 + random() % 255));
    refused += IsRefused(bytes, "changed at " + std::to_string(place));
  }
  EXPECT_GT(refused, 20);
}

TEST_F(Damage, HolesAndOtherFiles) {
  EXPECT_TRUE(IsRefused(std::string(whole_.size(), '\0'), "zeros"));
  for (std::size_t page = 1; page < whole_.size() / 4096; ++page) {
    std::string hole = whole_;
    std::fill_n(hole.begin() + static_cast<std::ptrdiff_t>(4096 * page), 4096, '\0');
    IsRefused(hole, "zeros in page " + std::to_string(page));
  }
  EXPECT_TRUE(IsRefused("benchmark b { }\n", "another file"));
  EXPECT_FALSE(IsRefused(whole_, "as it was"));
  const results::ResultFile file(folder_ / "out.h5");
  for (const plan::Run& run : plan_.runs) ExpectAsWritten(file, run);
}

TEST(Checksum, SeesEverySingleByte) {
  std::string text(2000, 'x');
  for (std::size_t i = 0; i < text.size(); ++i) text[i] = static_cast<char>(i * i);
  const auto bytes = std::as_bytes(std::span(text));
  const std::uint64_t whole = files::Checksum(bytes);
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string changed = text;
    changed[i] = static_cast<char>(changed[i] + 1);
    ASSERT_NE(files::Checksum(std::as_bytes(std::span(changed))), whole) << i;
  }
  EXPECT_NE(files::Checksum(bytes.first(8)), files::Checksum(bytes.first(7)));
  const std::byte zeros[16] = {};
  EXPECT_NE(files::Checksum(std::span(zeros).first(8)), files::Checksum(std::span(zeros).first(9)));
}

TEST_F(Damage, OtherSchemasAndVersionsAreNamed) {
  const auto message = [&](const char* schema, double version) {
    hdf5::File file = hdf5::File::Create(folder_ / "other.h5");
    file.SetText("schema", schema);
    file.SetNumber("schema_version", hdf5::Type::kInt32, version);
    file.Close();
    try {
      results::ResultFile(folder_ / "other.h5");
    } catch (const files::StoreError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(message("cdb-results", 77), HasSubstr("schema version 77"));
  EXPECT_THAT(message("climate", 1), HasSubstr("not a result of cdb"));
  EXPECT_THAT(message("cdb-results", 1), HasSubstr("not a whole result")) << "has no arrays";
}

TEST_F(Damage, MergedFilesThatAreCutShortAreRefused) {
  journal::Merge(plan_, {}, folder_.path(), folder_ / "out.h5");
  const std::string whole = ReadFile(folder_ / "out.h5");
  for (std::size_t n = 0; n < whole.size(); n += 1 + whole.size() / Cases(300)) {
    WriteFile(folder_ / "out.h5", whole.substr(0, n));
    EXPECT_THROW(results::ResultFile(folder_ / "out.h5"), files::StoreError) << "cut to " << n;
  }
}

TEST_F(Damage, WhatIsNoResultIsNamed) {
  const auto message = [](const std::filesystem::path& path) {
    try {
      const results::ResultFile file(path);
    } catch (const files::StoreError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(message(folder_ / "none.h5"), HasSubstr("no such file"));
  EXPECT_THAT(message(folder_.path()), HasSubstr("is a folder"));
  WriteFile(folder_ / "text.h5", "hello");
  EXPECT_THAT(message(folder_ / "text.h5"), HasSubstr("not a whole result"));
  hdf5::File::Create(folder_ / "foreign.h5").Close();
  EXPECT_THAT(message(folder_ / "foreign.h5"), HasSubstr("not a result of cdb"));
}

}  // namespace
}  // namespace cdb::tests
