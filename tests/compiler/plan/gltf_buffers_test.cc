#include "compiler/plan/gltf_buffers.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace cdb::tests {
namespace {

class GltfBuffers : public testing::Test {
 protected:
  std::optional<std::string> Joined(const std::string& path, const std::string& text) {
    const auto read = [this](const std::string& file,
                             std::string& why) -> std::optional<std::string> {
      read_.push_back(file);
      if (file.ends_with("none.bin")) {
        why = "there is no such file";
        return std::nullopt;
      }
      return "0123456789";
    };
    return plan::WithGltfBuffers(path, text, read, 200, why_);
  }
  std::vector<std::string> read_;
  std::string why_;
};

TEST_F(GltfBuffers, FollowTheFileInTheirOrder) {
  const std::string text =
      R"({"buffers":[{"uri":"a.bin","byteLength":3},{"uri":"data:,x","byteLength":1},)"
      R"({"uri":"in/b%201.bin","byteLength":10},{"byteLength":4}]})";
  EXPECT_EQ(Joined("models/s.GLTF", text), text + "0120123456789");
  EXPECT_EQ(read_, (std::vector<std::string>{"models/a.bin", "models/in/b 1.bin"}));
}

TEST_F(GltfBuffers, LeaveOtherAndDamagedFilesAsTheyAre) {
  for (const std::string text :
       {"", "{", "[]", R"({"buffers":3})", R"({"buffers":[3,{"uri":4}]})",
        R"({"buffers":[{"uri":"a.bin"}]})", R"({"buffers":[{"uri":"a.bin","byteLength":-1}]})"})
    EXPECT_EQ(Joined("s.gltf", text), text);
  const std::string named = R"({"buffers":[{"uri":"a.bin","byteLength":3}]})";
  EXPECT_EQ(Joined("s.glb", named), named);
  EXPECT_TRUE(read_.empty());
}

TEST_F(GltfBuffers, AreRefusedOutsideTheFolder) {
  for (const std::string uri : {"../a.bin", "/a.bin", "in/../../a.bin", "%2E%2e/a.bin", "C:a.bin",
                                "file:///a.bin", "..\\\\a.bin", "a%00.bin", ""}) {
    EXPECT_FALSE(Joined("s.gltf", R"({"buffers":[{"uri":")" + uri + R"(","byteLength":3}]})"))
        << uri;
    EXPECT_NE(why_.find("which is not in its folder"), std::string::npos) << why_;
  }
  EXPECT_TRUE(read_.empty());
}

TEST_F(GltfBuffers, AreRefusedIfMissingShortOrLarge) {
  EXPECT_FALSE(Joined("s.gltf", R"({"buffers":[{"uri":"none.bin","byteLength":3}]})"));
  EXPECT_EQ(why_, "its data are in 'none.bin': there is no such file");
  EXPECT_FALSE(Joined("s.gltf", R"({"buffers":[{"uri":"a.bin","byteLength":11}]})"));
  EXPECT_EQ(why_, "its data are in 'a.bin', which has 10 bytes instead of 11");
  EXPECT_FALSE(
      Joined("s.gltf", R"({"buffers":[{"uri":"a.bin","byteLength":10}]})" + std::string(150, ' ')));
  EXPECT_EQ(why_, "it and its data have more than 200 bytes");
}

}  // namespace
}  // namespace cdb::tests
