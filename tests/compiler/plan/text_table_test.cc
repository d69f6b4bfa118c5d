#include "compiler/plan/text_table.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace cdb::tests {
namespace {

using plan::Column;
using plan::Dialect;
using plan::TextTable;

using Rows = std::vector<std::vector<double>>;

Rows NumbersOf(const std::string& text, const Dialect& dialect = {}) {
  TextTable table(text, "a.csv", dialect);
  std::vector<Column> columns;
  for (std::size_t i = 0; i < table.width(); ++i) columns.push_back(table.At(i));
  table.FindDecimal(columns);
  Rows rows(table.rows());
  for (std::size_t row = 0; row < table.rows(); ++row)
    for (const Column& column : columns) rows[row].push_back(table.Number(row, column));
  return rows;
}

std::string FaultOf(const std::string& text, const Dialect& dialect = {}) {
  try {
    NumbersOf(text, dialect);
  } catch (const plan::TableError& error) {
    return std::string(error.what()) + "; " + error.remedy;
  }
  return "";
}

std::string FaultOfFinding(const std::string& text, const char* name) {
  try {
    TextTable(text, "a.csv", {}).Find(name);
  } catch (const plan::TableError& error) {
    return std::string(error.what()) + "; " + error.remedy;
  }
  return "";
}

TEST(TextTable, RecognisesHowItIsWritten) {
  const Rows two = {{1.5, -2}, {3, 0.25}};
  for (const char* text : {
           "1.5,-2\n3,.25\n",                                           // numbers alone
           "a,b\r\n1.5,-2\r\n+3,0.25",                                  // CR LF, no end of line
           "a;b\n1,5;-2\n3;0,25\n",                                     // decimal commas
           "a\tb\n1,5\t-2\n3\t0,25\n",                                  // tabs
           "1,5 -2\n 3   2,5e-1 \n",                                    // spaces
           "\xEF\xBB\xBFsep=;\r\na;b\r\n1,5;-2\r\n3;0,25\r\n;\r\n",     // Excel
           "\"a\",\"b, \"\"c\"\"\"\n\"1,5\",\"-2\"\n\"3\",\"0,25\"\n",  // quotes
           "\"a;1\";\"b\"\n\"1.5\";-2\n3;\"0.25\"\n",   // another separator in quotes
           "\"a\nb\",c\n# no row\n1.5,-2\n\n3,0.25\n",  // a heading in two lines
           "# a b\n1.5 -2\n3 0.25\n",                   // headings in a comment
           "a x;y,b\n1.5,-2\n3,0.25\n",                 // only commas fit the numbers
       })
    EXPECT_EQ(NumbersOf(text), two) << text << FaultOf(text);
  EXPECT_EQ(NumbersOf("a [mm],b (deg/s)\n1500,-180\n"), (Rows{{1.5, -3.141592653589793}}));
  EXPECT_EQ(NumbersOf("t,x\nns,Millimeters\n1403636579758555392,2\n"),
            (Rows{{1403636579.7585554, 0.002}}));
  EXPECT_EQ(NumbersOf("Format,1.2\nTake,x\na,b\n1.5,2\n", {.header = 3}), (Rows{{1.5, 2}}));
  EXPECT_EQ(NumbersOf("1,5\n2,5\n", {.decimal = ','}), (Rows{{1.5}, {2.5}}));
  EXPECT_EQ(NumbersOf("1,5\n2,5\n", {.separator = ','}), (Rows{{1, 5}, {2, 5}}));
  EXPECT_EQ(NumbersOf("1, 5\n2,5\n"), (Rows{{1, 5}, {2, 5}}));  // no number has a blank
}

TEST(TextTable, RefusesWhatCanBeReadInTwoWays) {
  const std::pair<const char*, const char*> rows[] = {
      {"1,5\n2,5\n", "a.csv:1: `1,5` may be one number with a decimal comma, or two numbers; name"},
      {"1\n2,5\n", "a.csv:2: `2,5` may be one number with a decimal comma, or two numbers"},
      {"size\n1,5\n", "a.csv:2: `1,5` may be one number with a decimal comma, or two numbers"},
      {"a;b\n1,234;5\n", "a.csv:2: `1,234` may be a number with a decimal comma, or thousands; w"},
      {"a;b\n1,5;2.5\n", "a.csv:2: it has numbers with a comma, `1,5` in line 2, and with a point"},
      {"a;b,c\n1;2,3\n", "a.csv:1: semicolons and commas may separate the columns; name one: sepa"},
      {"r1,1.5\nr2,3\n", "a.csv:1: it has words and numbers, so it may be headings or values; nam"},
      {"Format,1.2\n\na,b,c\n,mm,mm\n1,2,3\n",
       "name the line of the headings: header: 3, or write h"},
      {"Rigid\nFrame,x\n1,2,3\n", "a.csv:2: Rigid is `Frame,x`, which is not a finite"},
      {"\"a\n1\n", "a.csv:1: a quoted field does not end; write the second quote"},
      {"\"a\"b,c\n1,2\n", "a.csv:1: text follows a quoted field"},
      {"a,b\n1,2\n3\n", "a.csv:3: 1 value in this line, but 2 columns"},
      {"a,b\n1,x\n", "a.csv:2: b is `x`, which is not a finite number"},
      {"a;b\n1,5;\n", "a.csv:2: b is ``, which is not a finite number; write a number with a deci"},
      {"sep=|\n1|2\n", "a.csv:1: `|` cannot separate columns"},
      {"a [furlong]\n1\n", "a.csv:1: `furlong` in the heading `a [furlong]` is not a known unit"},
      {"x_mm\n1\n", "a.csv:1: the column `x_mm` may be in mm; write its unit after the name: \"x_"},
  };
  for (const auto& [text, message] : rows)
    EXPECT_NE(FaultOf(text).find(message), std::string::npos) << text << "\n" << FaultOf(text);
  EXPECT_NE(FaultOf(std::string("\xFF\xFE"
                                "1\0",
                                4))
                .find("not text in UTF-8"),
            std::string::npos);
}

TEST(TextTable, FindsColumnsByNameAndNumber) {
  const std::string text = "x [mm],X,X,y_mm,\"z, up\"\n1,2,3,4,5\n";
  TextTable table(text, "a.csv", {});
  const auto number = [&](const char* name) { return table.Number(0, table.Find(name)); };
  EXPECT_EQ(number("x [mm]"), 0.001);
  EXPECT_EQ(number("x"), 0.001);
  EXPECT_EQ(number("#3"), 3);
  EXPECT_EQ(number("#2 [cm]"), 0.02);
  EXPECT_EQ(number("y_mm [m]"), 4);
  EXPECT_EQ(number("z, up"), 5);
  EXPECT_NE(
      FaultOfFinding(text, "X").find("`X` occurs twice, as #2 and #3; name the column by its"),
      std::string::npos);
  EXPECT_NE(FaultOfFinding(text, "x [m]").find("has another unit in the file than m"),
            std::string::npos);
  EXPECT_NE(FaultOfFinding(text, "w").find("it has no column `w`; its columns are #1 x [mm], #2 X"),
            std::string::npos);
  EXPECT_NE(FaultOfFinding(text, "#6").find("no column `#6`"), std::string::npos);
  EXPECT_NE(FaultOfFinding(text, "#2 [ell]").find("`ell` is not a known unit"), std::string::npos);
  const std::string euroc = "#timestamp [ns], p [m], q []\n5,1,2\n";
  EXPECT_EQ(TextTable(euroc, "a.csv", {}).Find("#timestamp [ns]").index, 0u);
  EXPECT_EQ(TextTable(euroc, "a.csv", {}).Find("timestamp").index, 0u);
}

/// Random tables in random dialects read back to the same numbers, or are refused: never to other
/// numbers.
TEST(TextTable, ReadsRandomTablesBack) {
  std::mt19937 random(7);
  const auto below = [&](unsigned n) { return random() % n; };
  std::size_t read = 0;
  for (int round = 0; round < 3000; ++round) {
    const char separator = ",;\t "[below(4)], decimal = below(2) == 0 ? '.' : ',';
    const std::size_t width = 1 + below(5), height = 1 + below(6);
    const bool has_header = below(2) == 0, quotes = below(4) == 0;
    const std::string end = below(2) == 0 ? "\r\n" : "\n";
    std::string text = below(4) == 0 ? "\xEF\xBB\xBF" : "";
    Rows rows(height);
    const auto add = [&](std::size_t i, std::string field, bool must_quote) {
      if (i > 0) text += separator;
      if (must_quote || (quotes && below(2) == 0)) field = '"' + field + '"';
      text += field;
    };
    for (std::size_t i = 0; has_header && i < width; ++i)
      add(i, "c" + std::to_string(i) + (below(5) == 0 ? " d" : ""), separator == ' ');
    if (has_header) text += end;
    for (auto& row : rows) {
      for (std::size_t i = 0; i < width; ++i) {
        std::string field = std::to_string(below(3000));
        if (below(2) == 0) field += decimal + std::to_string(below(1000));
        std::string plain = field;
        if (decimal == ',' && plain.find(',') != plain.npos) plain[plain.find(',')] = '.';
        row.push_back(std::stod(plain));
        add(i, field, separator == ',' && field.find(',') != field.npos);
      }
      text += end;
    }
    Rows back;
    try {
      back = NumbersOf(text);
    } catch (const plan::TableError& error) {
      const std::string why = error.what();
      EXPECT_TRUE(why.find("may be") != why.npos) << why << "\n" << text;
      Dialect named{separator, decimal, has_header ? 1 : Dialect::kNoHeader};
      back = NumbersOf(text, named);
      --read;
    }
    ++read;
    EXPECT_EQ(back, rows) << text;
  }
  EXPECT_GT(read, 2000u);
}

}  // namespace
}  // namespace cdb::tests
