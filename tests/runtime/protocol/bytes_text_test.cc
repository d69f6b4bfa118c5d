#include "runtime/protocol/bytes_text.h"

#include <gtest/gtest.h>

namespace cdb::tests {
namespace {

TEST(BytesText, HasThreeDigitsAndTheUnitThatFits) {
  EXPECT_EQ(protocol::BytesText(0), "0 B");
  EXPECT_EQ(protocol::BytesText(999), "999 B");
  EXPECT_EQ(protocol::BytesText(999.6), "1 kB");
  EXPECT_EQ(protocol::BytesText(4321), "4.32 kB");
  EXPECT_EQ(protocol::BytesText(2e9), "2 GB");
  EXPECT_EQ(protocol::BytesText(999.9e6), "1 GB");
  EXPECT_EQ(protocol::BytesText(3e20), "3e+05 PB");
}

}  // namespace
}  // namespace cdb::tests
