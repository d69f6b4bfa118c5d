#include "library/meshes/hull_cache.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "tests/library/meshes/test_meshes.h"

namespace cdb::library {
namespace {

using namespace testing;
namespace fs = std::filesystem;

class HullCache : public ::testing::Test {
 protected:
  HullCache() {
    std::string name = (fs::temp_directory_path() / "cdb-hulls-XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~HullCache() override { fs::remove_all(folder_); }

  static DecomposeOptions Options() {
    DecomposeOptions options;
    options.faces = 100;
    return options;
  }
  CachedDecomposition Once(const fs::path& folder) const {
    return DecomposeOnce(mesh_, "m", Options(), folder);
  }
  std::vector<fs::path> Files() const {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder_ / "new" / "cache"))
      files.push_back(entry.path());
    return files;
  }

  Mesh mesh_ = AngleMesh();
  fs::path folder_;
};

TEST_F(HullCache, ComputesOnce) {
  const Decomposition direct = Decompose(mesh_, "m", Options());
  const fs::path cache = folder_ / "new" / "cache";
  const CachedDecomposition first = Once(cache), second = Once(cache);
  EXPECT_EQ(first.use, CacheUse::kStored);
  EXPECT_EQ(second.use, CacheUse::kFound);
  EXPECT_EQ(first.decomposition, direct);
  EXPECT_EQ(second.decomposition, direct);
  EXPECT_EQ(Files(), std::vector{cache / (CacheKey(mesh_, Options()) + ".hulls")});
}

TEST_F(HullCache, WhatIsFoundIsWhatIsThere) {
  // A valid entry of another shape under this key would be believed; its digest is all that counts.
  const fs::path cache = folder_ / "new" / "cache";
  Once(cache);
  std::ifstream stream(Files()[0], std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(stream), {}};
  ASSERT_GT(whole.size(), 200u);
  const Decomposition right = Once(cache).decomposition;
  // Each damage is found, recomputed and mended.
  std::vector<std::string> damages = {"", whole + "x", whole.substr(1),
                                      whole.substr(0, whole.size() - 1)};
  for (std::size_t at = 0; at < whole.size(); at += whole.size() / 23) {
    damages.push_back(whole);
    damages.back()[at] = static_cast<char>(damages.back()[at] ^ 1);
  }
  for (const std::string& damage : damages) {
    std::ofstream(Files()[0], std::ios::binary | std::ios::trunc) << damage;
    const CachedDecomposition mended = Once(cache);
    EXPECT_EQ(mended.use, CacheUse::kStored);
    EXPECT_EQ(mended.decomposition, right);
  }
  EXPECT_EQ(Once(cache).use, CacheUse::kFound);
}

TEST_F(HullCache, AFolderThatCannotBeWrittenIsNoError) {
  std::ofstream(folder_ / "file") << "x";
  EXPECT_EQ(Once(folder_ / "file" / "cache").use, CacheUse::kNotStored);
  EXPECT_EQ(Once({}).use, CacheUse::kNotStored);
  // The name of the entry is taken by a folder that is not empty, so that the rename fails.
  const fs::path cache = folder_ / "new" / "cache";
  fs::create_directories(cache / (CacheKey(mesh_, Options()) + ".hulls") / "x");
  const CachedDecomposition result = Once(cache);
  EXPECT_EQ(result.use, CacheUse::kNotStored);
  EXPECT_FALSE(result.decomposition.hulls.empty());
  EXPECT_EQ(Files().size(), 1u);  // nothing temporary is left
}

TEST_F(HullCache, KeysTellAllInputsApart) {
  std::vector<std::string> keys = {CacheKey(mesh_, Options())};
  EXPECT_EQ(CacheKey(mesh_, Options()), keys[0]);
  EXPECT_EQ(keys[0].size(), 64u);
  const auto add = [&](const auto& change) {
    Mesh mesh = mesh_;
    DecomposeOptions options = Options();
    change(mesh, options);
    const std::string key = CacheKey(mesh, options);
    EXPECT_EQ(std::find(keys.begin(), keys.end(), key), keys.end());
    keys.push_back(key);
  };
  add([](Mesh& m, DecomposeOptions&) { m.vertices[0].x() = std::nextafter(0.0, 1.0); });
  add([](Mesh& m, DecomposeOptions&) { std::swap(m.triangles[0], m.triangles[1]); });
  add([](Mesh&, DecomposeOptions& o) { ++o.faces; });
  add([](Mesh&, DecomposeOptions& o) { ++o.concavity; });
  add([](Mesh&, DecomposeOptions& o) { ++o.compacity; });
  add([](Mesh&, DecomposeOptions& o) { ++o.least_pieces; });
  add([](Mesh&, DecomposeOptions& o) { ++o.vertices_per_hull; });
  add([](Mesh&, DecomposeOptions& o) { ++o.least_volume; });
  add([](Mesh&, DecomposeOptions& o) { ++o.good_iou; });
}

TEST_F(HullCache, ProcessesAtOnceAllGetTheSame) {
  const fs::path cache = folder_ / "new" / "cache";
  const Decomposition direct = Decompose(mesh_, "m", Options());
  std::vector<pid_t> children;
  for (int i = 0; i < 4; ++i) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) _exit(Once(cache).decomposition == direct ? 0 : 1);
    children.push_back(child);
  }
  for (const pid_t child : children) {
    int status = -1;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
  }
  EXPECT_EQ(Once(cache).use, CacheUse::kFound);
  EXPECT_EQ(Files().size(), 1u);
}

TEST_F(HullCache, FolderComesFromTheEnvironment) {
  setenv("CDB_CACHE", "/a", 1);
  setenv("XDG_CACHE_HOME", "/b", 1);
  setenv("HOME", "/c", 1);
  EXPECT_EQ(CacheFolder(), "/a");
  unsetenv("CDB_CACHE");
  EXPECT_EQ(CacheFolder(), "/b/cdb");
  setenv("XDG_CACHE_HOME", "relative", 1);
  EXPECT_EQ(CacheFolder(), "/c/.cache/cdb");
  unsetenv("XDG_CACHE_HOME");
  unsetenv("HOME");
  EXPECT_EQ(CacheFolder(), "");
}

}  // namespace
}  // namespace cdb::library
