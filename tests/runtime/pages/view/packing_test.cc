#include "runtime/pages/view/scene_document.h"

#include <gtest/gtest.h>

#include <limits>

#include "library/distributions/stream.h"
#include "tests/runtime/pages/view/unpack.h"

namespace cdb::tests {
namespace {

std::string Base64Of(std::string_view text) {
  return view::Base64(std::as_bytes(std::span(text.data(), text.size())));
}

// Source: RFC 4648, section 10.
TEST(Packing, IsBase64) {
  EXPECT_EQ(Base64Of(""), "");
  EXPECT_EQ(Base64Of("f"), "Zg==");
  EXPECT_EQ(Base64Of("fo"), "Zm8=");
  EXPECT_EQ(Base64Of("foo"), "Zm9v");
  EXPECT_EQ(Base64Of("foobar"), "Zm9vYmFy");
}

TEST(Packing, KeepsFloats) {
  const std::vector<double> values = {0, -1.5, 1e30, std::numeric_limits<double>::quiet_NaN()};
  const std::vector<float> read = Unpack<float>(view::PackFloats(values));
  ASSERT_EQ(read.size(), values.size());
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(read[i], static_cast<float>(values[i]));
  EXPECT_TRUE(std::isnan(read[3]));
}

TEST(Packing, KeepsOrientationsWithinItsBound) {
  auto stream = distributions::Stream(11);
  for (int i = 0; i < 2000; ++i) {
    Eigen::Quaterniond q(stream.Normal(), stream.Normal(), stream.Normal(), stream.Normal());
    q.normalize();
    const bool flag = i % 3 == 0;
    const auto words = view::PackQuaternion(q, flag);
    EXPECT_EQ(words[2] >> 15 == 1, flag);
    Eigen::Quaterniond read = UnpackQuaternion(words.data());
    if (read.dot(q) < 0) read.coeffs() = -read.coeffs();  // the same rotation
    for (int k = 0; k < 4; ++k) {
      // The largest component follows from the others, and is at least 1/2.
      EXPECT_NEAR(read.coeffs()[k], q.coeffs()[k], 3 * view::kQuaternionError);
    }
  }
}

TEST(Packing, MakesTheIdentityOfWhatIsNoTurn) {
  const auto words = view::PackQuaternion({NAN, 0, 0, 0}, false);
  EXPECT_NEAR(UnpackQuaternion(words.data()).w(), 1, 1e-8);
}

}  // namespace
}  // namespace cdb::tests
