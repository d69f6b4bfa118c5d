// Random texts in the language, valid and invalid, reproducible from a seed on every machine.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <string_view>

namespace cdb::tests {

class RandomText {
 public:
  explicit RandomText(std::uint64_t seed) : engine_(seed) {}

  /// A valid file with random white space and comments, and the dump of its tree, which is built
  /// along with the text, not by the parser.
  struct Sample {
    std::string text;
    std::string dump;
  };
  Sample File();

  /// Random tokens.
  std::string Soup();
  /// The text with some bytes or words changed, moved, duplicated or deleted.
  std::string Mutate(std::string text);

 private:
  enum Level { kSum = 1, kProduct, kPower, kUnary, kPrimary };
  struct Piece {
    std::string text;
    std::string dump;
    int level = kPrimary;  // precedence of its outermost operator
  };

  int Below(int count) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(count)); }
  bool OneIn(int count) { return Below(count) == 0; }
  std::string Space();
  std::string Gap();
  std::string Break();
  std::string LineEnd();
  std::string Name();
  std::string Number();
  std::string Text(std::string* dump);
  Piece Expr(int depth);
  Piece At(int level, int depth);
  Piece Primary(int depth);
  Piece Quantity(int depth);
  Piece Call(int depth);
  Piece Value(int depth);
  Piece ValueOrBareCall(int depth);
  Piece Range(int depth);
  Piece Condition(int depth);
  Piece Operand(int depth);
  void Statement(int level, int depth, Sample& out);
  void Block(int level, int depth, Sample& out);

  std::mt19937_64 engine_;
};

}  // namespace cdb::tests
