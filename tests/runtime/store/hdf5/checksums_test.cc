#include "runtime/store/hdf5/checksums.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace cdb::tests {
namespace {

std::uint32_t Lookup3(std::string_view text) {
  return hdf5::Lookup3(std::as_bytes(std::span(text)));
}

TEST(Checksums, AreThoseOfLookup3) {
  // From lookup3.c, driver5.
  EXPECT_EQ(Lookup3(""), 0xdeadbeef);
  EXPECT_EQ(Lookup3("Four score and seven years ago"), 0x17770551);
  // Pieces have 12 bytes; the last one may be whole.
  EXPECT_NE(Lookup3("123456789012"), Lookup3(std::string_view("123456789012\0", 13)));
}

}  // namespace
}  // namespace cdb::tests
