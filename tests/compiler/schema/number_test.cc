#include "compiler/schema/number.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

namespace cdb::tests {
namespace {

schema::Number N(std::string_view literal) { return *schema::Number::FromLiteral(literal); }

TEST(Number, WholeNumbersStayExact) {
  EXPECT_EQ((N("9007199254740993") + N("1")).Text(), "9007199254740994");
  EXPECT_EQ((N("0xFFFFFFFFFFFFFFFF") - N("1")).Text(), "18446744073709551614");
  EXPECT_EQ((N("4294967296") * N("4294967295")).Text(), "18446744069414584320");
  EXPECT_EQ((N("12") / N("4")).Text(), "3");
  EXPECT_TRUE((N("12") / N("4")).is_whole());
  EXPECT_EQ((N("1") / N("8")).Text(), "0.125");
  EXPECT_EQ(Power(N("3"), N("40")).Text(), "12157665459056928801");
  EXPECT_EQ((-N("5")).Text(), "-5");
}

TEST(Number, GoesOnAsARealPast64Bits) {
  const schema::Number big = N("0xFFFFFFFFFFFFFFFF") * N("0xFFFFFFFFFFFFFFFF");
  EXPECT_FALSE(big.is_whole());
  EXPECT_DOUBLE_EQ(big.AsReal(), std::ldexp(1.0, 128));
  EXPECT_FALSE(Power(N("10"), N("60")).is_whole());
  EXPECT_DOUBLE_EQ(Power(N("10"), N("60")).AsReal(), 1e60);
}

TEST(Number, ComparesExactly) {
  EXPECT_TRUE(Compare(N("9007199254740993"), N("9007199254740992")) > 0);
  EXPECT_TRUE(Compare(N("1"), N("1.0")) == 0);
  EXPECT_TRUE(Compare(N("0.1"), N("0.2")) < 0);
}

TEST(Number, RealsThatAreWholeAreCounts) {
  EXPECT_EQ(N("1e6").AsWhole(), schema::Integer{1000000});
  EXPECT_FALSE(N("1.5").AsWhole());
  EXPECT_FALSE(N("1e17").AsWhole()) << "past 2^53 a real has no last digit";
}

TEST(Number, Literals) {
  EXPECT_EQ(N("1_000_000").Text(), "1000000");
  EXPECT_EQ(N("0xAA").Text(), "170");
  EXPECT_FALSE(schema::Number::FromLiteral("1e999"));
  EXPECT_FALSE(schema::Number::FromLiteral("0x1FFFFFFFFFFFFFFFF"));
}

TEST(FormatReal, ReadsBackAsTheSameBits) {
  for (const double value : {0.1, 1.0 / 60, 1e-300, -0.0, 250.0, 1e22, 5e-324}) {
    const std::string text = schema::FormatReal(value);
    const double back = std::strtod(text.c_str(), nullptr);
    EXPECT_EQ(std::signbit(back), std::signbit(value));
    EXPECT_EQ(back, value) << text;
  }
}

}  // namespace
}  // namespace cdb::tests
