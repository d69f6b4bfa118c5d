// Damaged files are rejected by name and never crash the reader.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <span>
#include <vector>

#include "runtime/store/files/safe_file.h"
#include "runtime/store/files/seal.h"
#include "runtime/store/hdf5/file.h"
#include "runtime/store/shards/shards.h"
#include "runtime/store/store.h"
#include "tests/runtime/store/store_fixture.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

using testing::HasSubstr;

class Damage : public testing::Test {
 protected:
  Damage() {
    shards::WriteShard(plan_, run_, FakeResult(run_).result, TestProvenance(), folder_.path());
    shard_ = ReadFile(path_);
  }

  /// Expects that info and merge reject the file by name, and that reading it as a result ends in
  /// an error or in the dimensions that the header states.
  void ExpectRefused(const std::string& bytes, const std::string& what) {
    SCOPED_TRACE(what);
    WriteFile(path_, bytes);
    try {
      shards::ReadShardInfo(path_);
      ADD_FAILURE() << "was taken for a shard";
    } catch (const files::StoreError& error) {
      EXPECT_THAT(error.what(), HasSubstr(path_.string()));
      EXPECT_THAT(error.what(), HasSubstr("remove it and its run is done again"));
    }
    EXPECT_THROW(shards::Merge(plan_, {}, folder_.path(), folder_ / "out.h5"), files::StoreError);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out.h5"));
    ReadAsResult(path_);
  }

  static void ReadAsResult(const std::filesystem::path& path) {
    try {
      const store::ResultFile file(path);
      const store::ResultFile::Cell cell = {{0}, 0};
      file.ReadStatus(cell);
      file.ReadText("message", cell);
      file.ReadDuration(measure::Phase::kStep, cell);
      file.ReadSeries("energy", cell);
      file.ReadProvenance("run_text");
    } catch (const files::StoreError& error) {
      EXPECT_THAT(error.what(), HasSubstr(path.filename().string()));
    }
  }

  const TemporaryFolder folder_;
  const plan::Plan plan_ = MakePlan({NumberAxis("quantity", {10, 20})}, 1, {.cycles = 50});
  const plan::Run& run_ = plan_.runs[0];
  const std::filesystem::path path_ = folder_ / (run_.id + ".h5");
  std::string shard_;
};

TEST_F(Damage, EveryKindOfTruncation) {
  constexpr std::size_t kStep = kAnySanitizer ? 3 : 1;
  std::vector<std::size_t> lengths;
  for (std::size_t n = 0; n <= 100; n += kStep) lengths.push_back(n);
  for (std::size_t n = 101; n < shard_.size(); n += shard_.size() / Cases(200))
    lengths.push_back(n);
  for (std::size_t n = 1; n <= 60; n += kStep) lengths.push_back(shard_.size() - n);
  for (const std::size_t n : lengths)
    ExpectRefused(shard_.substr(0, n), "cut to " + std::to_string(n));
}

TEST_F(Damage, EveryKindOfFlippedByte) {
  std::mt19937 random(20260101);
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < 100; ++i) places.push_back(i);
  for (std::size_t i = 1; i <= 48; ++i) places.push_back(shard_.size() - i);
  for (int i = 0; i < Cases(400); ++i) places.push_back(random() % shard_.size());
  for (const std::size_t place : places) {
    std::string bytes = shard_;
    bytes[place] = static_cast<char>(bytes[place] ^ (1 + random() % 255));
    ExpectRefused(bytes, "changed at " + std::to_string(place));
  }
}

TEST_F(Damage, HolesAndTails) {
  ExpectRefused(shard_ + "x", "a byte too many");
  ExpectRefused(shard_ + shard_, "twice");
  ExpectRefused(std::string(shard_.size(), '\0'), "zeros");
  std::string hole = shard_;
  std::fill_n(hole.begin() + 4096, 4096, '\0');
  ExpectRefused(hole, "a page of zeros");
  ExpectRefused("benchmark b { }\n", "another file");
}

TEST_F(Damage, ChecksumSeesEverySingleByte) {
  const auto bytes = std::as_bytes(std::span(shard_));
  const std::uint64_t whole = files::Checksum(bytes);
  for (std::size_t i = 0; i < 2000; ++i) {
    std::string changed = shard_;
    changed[i] = static_cast<char>(changed[i] + 1);
    ASSERT_NE(files::Checksum(std::as_bytes(std::span(changed))), whole) << i;
  }
  EXPECT_NE(files::Checksum(bytes.first(8)), files::Checksum(bytes.first(7)));
  const std::byte zeros[16] = {};
  EXPECT_NE(files::Checksum(std::span(zeros).first(8)), files::Checksum(std::span(zeros).first(9)));
}

TEST_F(Damage, OtherSchemasAndVersionsAreNamed) {
  const auto seal = [&](const char* schema, double version) {
    hdf5::File file = hdf5::File::CreateInMemory();
    file.SetText("schema", schema);
    file.SetNumber("schema_version", hdf5::Type::kInt32, version);
    files::WriteSealed(file.Image(), path_);
    try {
      shards::ReadShardInfo(path_);
    } catch (const files::StoreError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(seal("cdb-results", 77), HasSubstr("schema version 77"));
  EXPECT_THAT(seal("climate", 1), HasSubstr("not a result of cdb"));
  EXPECT_THAT(seal("cdb-results", 1), HasSubstr("no whole shard")) << "has the head and no arrays";
}

TEST_F(Damage, MergedFilesThatAreCutShortAreRefused) {
  shards::WriteShard(plan_, plan_.runs[1], FakeResult(plan_.runs[1]).result, {}, folder_.path());
  shards::Merge(plan_, {}, folder_.path(), folder_ / "out.h5");
  const std::string whole = ReadFile(folder_ / "out.h5");
  for (std::size_t n = 0; n < whole.size(); n += 1 + whole.size() / Cases(300)) {
    WriteFile(folder_ / "out.h5", whole.substr(0, n));
    EXPECT_THROW(store::ResultFile(folder_ / "out.h5"), files::StoreError) << "cut to " << n;
  }
}

TEST_F(Damage, WhatIsNoResultIsNamed) {
  const auto message = [](const std::filesystem::path& path) {
    try {
      const store::ResultFile file(path);
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
