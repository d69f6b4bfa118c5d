// A merged file has a proof that it is unchanged, and files that crash HDF5 end only a separate
// process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <new>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "compiler/yaml/plan_yaml.h"
#include "runtime/results/examine.h"
#include "runtime/results/files/limited_process.h"
#include "runtime/results/files/seal.h"
#include "runtime/results/store.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/support/folders.h"
#include "tests/support/sanitizers.h"
#include "tests/support/scene.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Proof : public testing::Test {
 protected:
  Proof() {
    for (const plan::Run& run : plan_.runs)
      WriteRun(plan_, run, FakeResult(run).result, TestProvenance(), folder_.path());
    journal::Merge(plan_, TestProvenance(), folder_.path(), out_);
    whole_ = ReadFile(out_);
  }

  /// The reason why it cannot be read, or empty.
  std::string Fault(results::ProofOf of = results::ProofOf::kFewValues) const {
    try {
      const results::ResultFile file(out_, of);
      return {};
    } catch (const files::StoreError& error) {
      EXPECT_THAT(error.what(), HasSubstr(out_.string() + ": "));
      EXPECT_THAT(error.what(), HasSubstr("merge it again from its journal"));
      return error.what();
    }
  }

  /// Changes the file with HDF5 and seals it again.
  void Edit(const std::function<void(hid_t)>& edit) {
    WriteFile(out_, whole_.substr(0, whole_.size() - sizeof(files::Seal)));
    const hid_t file = H5Fopen(out_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    ASSERT_GE(file, 0);
    edit(file);
    ASSERT_GE(H5Fclose(file), 0);
    files::AppendSeal(out_, out_);
  }

  /// Replaces `name` by an array of other dimensions.
  void Replace(const char* name, hid_t type, const std::vector<hsize_t>& shape,
               hid_t creation = H5P_DEFAULT) {
    Edit([&](hid_t file) {
      H5Ldelete(file, name, H5P_DEFAULT);
      const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
      const hid_t dataset = H5Dcreate2(file, name, type, space, H5P_DEFAULT, creation, H5P_DEFAULT);
      EXPECT_GE(dataset, 0) << name;
      H5Dclose(dataset);
      H5Sclose(space);
    });
  }

  void Overwrite(const char* name, double value) {
    Edit([&](hid_t file) {
      const hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT);
      const hid_t space = H5Dget_space(dataset);
      const hsize_t first[8] = {};
      const int rank = H5Sget_simple_extent_ndims(space);
      H5Sselect_elements(space, H5S_SELECT_SET, 1, first);
      ASSERT_LE(rank, 8);
      const hid_t one = H5Screate(H5S_SCALAR);
      EXPECT_GE(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, one, space, H5P_DEFAULT, &value), 0);
      H5Sclose(one);
      H5Sclose(space);
      H5Dclose(dataset);
    });
  }

  const TemporaryFolder folder_;
  const plan::Plan plan_ = MakePlan({NumberAxis("quantity", {10, 20})}, 1, {.cycles = 50});
  const fs::path out_ = folder_ / "out.h5";
  std::string whole_;
};

TEST_F(Proof, AnyFlippedBitIsFound) {
  EXPECT_EQ(Fault(), "");
  EXPECT_TRUE(results::ResultFile(out_).has_digest());
  std::mt19937 random(20261123);
  std::vector<std::size_t> places;
  for (int i = 0; i < 400; ++i) places.push_back(random() % whole_.size());
  // The first bytes, and those of the seal after its name.
  for (std::size_t i = 0; i < 32; ++i) places.push_back(i);
  for (std::size_t i = 1; i <= 16; ++i) places.push_back(whole_.size() - i);
  for (const std::size_t place : places) {
    std::string bytes = whole_;
    bytes[place] = static_cast<char>(bytes[place] ^ (1 << random() % 8));
    WriteFile(out_, bytes);
    EXPECT_THAT(Fault(), HasSubstr("is damaged: its digest differs")) << place;
  }
}

TEST_F(Proof, AFileThatLostItsDigestIsDamaged) {
  for (std::size_t cut = 1; cut <= sizeof(files::Seal); ++cut) {
    WriteFile(out_, whole_.substr(0, whole_.size() - cut));
    EXPECT_THAT(Fault(results::ProofOf::kStructure), HasSubstr("its digest is missing")) << cut;
  }
  for (std::size_t i = 17; i <= sizeof(files::Seal); ++i) {
    std::string bytes = whole_;
    bytes[bytes.size() - i] = static_cast<char>(bytes[bytes.size() - i] ^ 1);
    WriteFile(out_, bytes);
    EXPECT_THAT(Fault(results::ProofOf::kStructure), HasSubstr("its digest is missing")) << i;
  }
}

TEST_F(Proof, FilesOfEarlierVersionsHaveNoDigest) {
  EXPECT_FALSE(results::ResultFile(SourceFolder() / "tests" / "golden" / "results" / "version1.h5")
                   .has_digest());
}

TEST_F(Proof, ChunksHaveChecksumsOfTheirOwn) {
  // In the first chunk of the energies, which other readers read without the digest.
  haddr_t begin = 0;
  {
    const hid_t file = H5Fopen(out_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    const hid_t dataset = H5Dopen2(file, "energy", H5P_DEFAULT);
    const hsize_t origin[3] = {};
    hsize_t bytes = 0;
    unsigned mask = 0;
    EXPECT_GE(H5Dget_chunk_info_by_coord(dataset, origin, &mask, &begin, &bytes), 0);
    EXPECT_EQ(mask, 0u);
    H5Dclose(dataset);
    H5Fclose(file);
  }
  std::string bytes = whole_.substr(0, whole_.size() - sizeof(files::Seal));
  bytes[begin + 20] = static_cast<char>(bytes[begin + 20] ^ 4);
  WriteFile(out_, bytes);
  files::AppendSeal(out_, out_);
  EXPECT_THAT(Fault(), HasSubstr("energy: "));
}

TEST_F(Proof, ImpossibleValuesAreRefusedThoughTheDigestFits) {
  Overwrite("duration", -5);
  EXPECT_THAT(Fault(), HasSubstr("duration holds -5, which is no duration"));
  Overwrite("duration", HUGE_VAL);
  EXPECT_THAT(Fault(), HasSubstr("which is no duration"));
  Overwrite("pairs", -7);
  EXPECT_THAT(Fault(), HasSubstr("pairs holds -7, which is no count"));
  Overwrite("status", 77);
  EXPECT_THAT(Fault(), HasSubstr("status holds 77, and has values from 0 to 5"));
  Overwrite("n_cycles", 51);
  EXPECT_THAT(Fault(), HasSubstr("n_cycles holds 51, and has values from -1 to 50"));
}

TEST_F(Proof, AFileWithoutItsPlanIsRefused) {
  Edit([](hid_t file) { H5Ldelete(file, "provenance/plan_text", H5P_DEFAULT); });
  EXPECT_THAT(Fault(), HasSubstr("it contains no plan"));
}

TEST_F(Proof, OtherShapesAndTypesAreRefused) {
  Replace("duration", H5T_IEEE_F64LE, {2, 1, 3, 50});
  EXPECT_THAT(Fault(results::ProofOf::kStructure), HasSubstr("duration has the shape [2 1 3 50]"));
  Replace("pairs", H5T_STD_I32LE, {2, 1, 1});
  EXPECT_THAT(Fault(results::ProofOf::kStructure), HasSubstr("pairs has the shape [2 1 1]"));
  Replace("pairs", H5T_IEEE_F64LE, {2, 1, 50});
  EXPECT_THAT(Fault(results::ProofOf::kStructure), HasSubstr("pairs holds values of another type"));
  Replace("energy", H5T_IEEE_F64BE, {2, 1, 50});
  EXPECT_THAT(Fault(results::ProofOf::kStructure), HasSubstr("a type of value"));
  Replace("cycle", H5T_STD_I32LE, {0});
  EXPECT_NE(Fault(results::ProofOf::kStructure), "");
  // The array is never written, so that the file stays small.
  for (const hsize_t huge : {hsize_t{1} << 32, hsize_t{1} << 61}) {
    Replace("cycle", H5T_STD_I32LE, {huge});
    EXPECT_NE(Fault(), "") << huge;
    Replace("quantity", H5T_STD_I32LE, {huge});
    EXPECT_NE(Fault(), "") << huge;
  }
}

TEST_F(Proof, NothingOutsideOfTheFileIsRead) {
  const std::string other = (folder_ / "other").string();
  WriteFile(other, std::string(4096, '\0'));
  const hid_t external = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_external(external, other.c_str(), 0, 1200);
  Replace("pairs", H5T_STD_I32LE, {2, 1, 50}, external);
  EXPECT_THAT(Fault(), HasSubstr("pairs: its values are in other files"));
  const hid_t filtered = H5Pcreate(H5P_DATASET_CREATE);
  const hsize_t chunk[] = {1, 1, 50};
  H5Pset_chunk(filtered, 3, chunk);
  H5Pset_filter(filtered, 32015, H5Z_FLAG_OPTIONAL, 0, nullptr);
  Replace("pairs", H5T_STD_I32LE, {2, 1, 50}, filtered);
  EXPECT_THAT(Fault(), HasSubstr("it has the filter 32015"));
  for (const char* name : {"pairs", "unknown"}) {
    Edit([&](hid_t file) {
      if (H5Lexists(file, name, H5P_DEFAULT) > 0) H5Ldelete(file, name, H5P_DEFAULT);
      H5Lcreate_soft("/energy", file, name, H5P_DEFAULT, H5P_DEFAULT);
    });
    EXPECT_NE(Fault(), "") << name;
  }
  H5Pclose(external);
  H5Pclose(filtered);
}

/// HDF5 steps from text to text by their sizes, and loops forever if one is 0.
TEST_F(Proof, TextsWithoutASizeAreRefusedBeforeHdf5ReadsThem) {
  std::string damaged = whole_.substr(0, whole_.size() - sizeof(files::Seal));
  const std::string heap("GCOL\1\0\0\0", 8);
  std::size_t heaps = 0;
  for (auto at = damaged.find(heap); at != std::string::npos; at = damaged.find(heap, at + 1)) {
    damaged.replace(at + 16, 16, 16, '\0');  // the head of its first object
    ++heaps;
  }
  ASSERT_GT(heaps, 0u);
  WriteFile(out_, damaged);
  files::AppendSeal(out_, out_);
  EXPECT_THAT(Fault(), HasSubstr("a text in it has no size"));
}

TEST_F(Proof, AMergeRefusesARunOfImpossibleNumbers) {
  const plan::Run& run = plan_.runs[1];
  FakeResult fake(run);
  fake.result.judgement.first_bad_cycle = 51;
  WriteRun(plan_, run, fake.result, {}, folder_.path());
  try {
    journal::Merge(plan_, {}, folder_.path(), out_);
    ADD_FAILURE();
  } catch (const files::StoreError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("its run " + run.id + " is damaged: first_bad_cycle holds 51"));
  }
  EXPECT_EQ(ReadFile(out_), whole_) << "the file of before is kept";
}

TEST(LimitedProcess, SaysHowItsWorkEnded) {
  const files::WorkLimits limits = {1, 256 << 20};
  EXPECT_EQ(files::RunLimited([] {}, limits), "");
  EXPECT_EQ(files::RunLimited([] { throw std::runtime_error("why"); }, limits), "why");
  EXPECT_THAT(files::RunLimited([] { std::abort(); }, limits), HasSubstr("HDF5 crashes on it"));
  EXPECT_THAT(files::RunLimited([] { throw std::bad_alloc(); }, limits),
              HasSubstr("more memory than such a file needs"));
  EXPECT_THAT(files::RunLimited(
                  [] {
                    for (std::atomic<int> i = 0;;) ++i;
                  },
                  limits),
              HasSubstr("takes longer than the 1 s"));
}

// At 33 MB, the plan of 20,000 runs, a limit without room for the plan's tree refused good files.
TEST(LimitedProcess, HasRoomForAPlanOfAnyLength) {
  if (kAnySanitizer) GTEST_SKIP() << "memory is not limited under a sanitizer";
  std::vector<double> masses(1200);
  std::iota(masses.begin(), masses.end(), 1.0);
  plan::Plan plan = MakePlan({NumberAxis("objects_mass", masses)}, 1, {});
  for (plan::Run& run : plan.runs) {
    run.scene = DefaultScene(3, 100);
    SetGroup(run.scene, "mass", masses[run.at[0]]);
    run.id = plan::RunId(run.scene, run.rep);
  }
  const std::string text = yaml::ToYaml(plan);
  ASSERT_GT(text.size(), 1u << 20);
  const auto read = [&](files::WorkLimits limits, const files::WorkLimits& least) {
    limits.memory_bytes -= least.memory_bytes;
    return files::RunLimited([&] { yaml::FromYaml(text, "plan"); }, limits);
  };
  EXPECT_EQ(read(results::LimitsForEveryValue(text.size()), results::LimitsForEveryValue(0)), "");
  // In a fresh process, whose heap has no free memory of other tests.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto read_and_exit = [&] {
    files::WorkLimits too_little = files::LimitsForFile(0);
    too_little.memory_bytes += text.size() / 4;
    std::fputs(read(too_little, files::LimitsForFile(0)).c_str(), stderr);
    std::exit(0);
  };
  EXPECT_EXIT(read_and_exit(), testing::ExitedWithCode(0), "more memory than such a file needs");
}

}  // namespace
}  // namespace cdb::tests
