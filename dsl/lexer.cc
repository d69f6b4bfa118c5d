#include "dsl/lexer.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "dsl/diagnostics.h"
#include "dsl/foreign_operators.h"
#include "dsl/text/concat.h"
#include "dsl/text/units.h"
#include "dsl/text/utf8.h"

namespace cdb::dsl {
namespace {

std::string Hex(std::uint32_t value, int width) {
  std::string digits;
  for (; value != 0 || static_cast<int>(digits.size()) < width; value /= 16)
    digits.insert(digits.begin(), "0123456789ABCDEF"[value % 16]);
  return digits;
}

class Lexer {
 public:
  Lexer(const text::Source& source, Diagnostics& diagnostics)
      : source_(source), text_(source.text()), diagnostics_(diagnostics) {}

  TokenList Run() {
    if (CheckEncoding())
      while (at_ < text_.size()) Next();
    Add(TokenKind::kEnd, text_.size());
    return std::move(result_);
  }

 private:
  bool CheckEncoding();
  void Next();
  void LexNewline();
  void LexComment();
  void LexForeignComment();
  void LexPath();
  void LexNumber();
  void LexText(char quote);
  void LexDots();
  void LexPercent();
  bool LexForeign();
  bool LexOperator();
  void LexUnknown();

  void CheckEscapes(std::size_t begin, std::size_t end);
  /// True at a letter outside ASCII that is not one of the foreign operators.
  bool AtForeignLetter(std::size_t at) const;
  std::size_t SkipNameChars(std::size_t at, bool* foreign) const;

  char At(std::size_t at) const { return at < text_.size() ? text_[at] : '\0'; }
  bool StartsWith(std::string_view word) const { return text_.substr(at_).starts_with(word); }
  text::Span SpanOf(std::size_t begin, std::size_t end) const {
    return {&source_, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end)};
  }
  void Add(TokenKind kind, std::size_t end, bool faulty = false) {
    const text::Span span = SpanOf(at_, end);
    result_.tokens.push_back({kind, faulty, span.begin, span.end});
    at_ = end;
  }
  bool AfterWordBeforeName() const {
    if (LastKind() != TokenKind::kPath) return false;
    const Token& last = result_.tokens.back();
    const std::string_view word = text_.substr(last.begin, last.end - last.begin);
    return word == "benchmark" || word == "from" || word == "let" || word == "cases";
  }
  TokenKind LastKind() const {
    return result_.tokens.empty() ? TokenKind::kNewline : result_.tokens.back().kind;
  }
  void Report(const DiagnosticKind& kind, std::size_t begin, std::size_t end, std::string message,
              std::string help = {}) {
    diagnostics_.Report(kind, SpanOf(begin, end), std::move(message), std::move(help));
  }

  const text::Source& source_;
  std::string_view text_;
  Diagnostics& diagnostics_;
  std::size_t at_ = 0;
  TokenList result_;
};

bool Lexer::CheckEncoding() {
  for (std::size_t at = 0; at < text_.size();) {
    const text::CodePoint point = text::DecodeUtf8(text_, at);
    if (point.bytes == 0) {
      const bool utf16 =
          at == 0 && (text_.starts_with("\xFF\xFE") || text_.starts_with("\xFE\xFF"));
      Report(kNotUtf8, at, at + 1,
             text::Concat({"the file is not UTF-8: byte ",
                           Hex(static_cast<unsigned char>(text_[at]), 2), " has no meaning here"}),
             utf16 ? "it looks like UTF-16; save it as UTF-8" : "save the file as UTF-8");
      return false;
    }
    if (point.value == 0) {
      Report(kNulByte, at, at + 1, "the file contains a NUL byte, so it is not a text file",
             "save the file as UTF-8");
      return false;
    }
    at += static_cast<std::size_t>(point.bytes);
  }
  return true;
}

void Lexer::Next() {
  const char c = text_[at_];
  if (c == ' ' || c == '\t') {
    ++at_;
  } else if (c == '\n' || (c == '\r' && At(at_ + 1) == '\n')) {
    LexNewline();
  } else if (c == '#') {
    LexComment();
  } else if (c == '/' && (At(at_ + 1) == '/' || At(at_ + 1) == '*')) {
    LexForeignComment();
  } else if (text::IsLetter(c) || AtForeignLetter(at_)) {
    LexPath();
  } else if (text::IsDigit(c) || (c == '.' && text::IsDigit(At(at_ + 1)))) {
    LexNumber();
  } else if (c == '"' || c == '\'') {
    LexText(c);
  } else if (c == '.' && At(at_ + 1) == '.') {
    LexDots();
  } else if (c == '%') {
    LexPercent();
  } else if (!LexForeign() && !LexOperator()) {
    LexUnknown();
  }
}

void Lexer::LexNewline() {
  const std::size_t end = at_ + (text_[at_] == '\r' && At(at_ + 1) == '\n' ? 2 : 1);
  const TokenKind last = LastKind();
  if (last == TokenKind::kNewline || last == TokenKind::kComma || last == TokenKind::kLeftParen ||
      last == TokenKind::kLeftBracket) {
    at_ = end;
  } else {
    Add(TokenKind::kNewline, end);
  }
}

void Lexer::LexComment() {
  std::size_t end = std::min(text_.find('\n', at_), text_.size());
  const std::size_t next = end;
  while (end > at_ && (text_[end - 1] == ' ' || text_[end - 1] == '\t' || text_[end - 1] == '\r'))
    --end;
  result_.comments.push_back(SpanOf(at_, end));
  // Leaves a CR LF line end whole for LexNewline.
  at_ = next < text_.size() && text_[next - 1] == '\r' ? next - 1 : next;
}

void Lexer::LexForeignComment() {
  const std::size_t line_end = std::min(text_.find_first_of("\r\n", at_), text_.size());
  if (text_[at_ + 1] == '/') {
    Report(kForeignComment, at_, at_ + 2, "a comment does not begin with '//'",
           "write '#' instead of '//'");
    at_ = line_end;
    return;
  }
  Report(kForeignComment, at_, at_ + 2, "comments are not written '/* … */'",
         "begin each line of the comment with '#'");
  const std::size_t close = text_.find("*/", at_ + 2);
  at_ = close == std::string_view::npos ? line_end : close + 2;
}

bool Lexer::AtForeignLetter(std::size_t at) const {
  if (at >= text_.size() || static_cast<unsigned char>(text_[at]) < 0x80) return false;
  const char32_t value = text::DecodeUtf8(text_, at).value;
  if (FindForeignOperator(text_.substr(at)) != nullptr) return false;
  // Latin-1 signs, spaces and general punctuation are not letters; nearly all above them are.
  return (value >= 0xC0 || value == 0xB5) && !(value >= 0x2000 && value <= 0x2BFF) &&
         value != 0x3000 && value != 0xFEFF;
}

std::size_t Lexer::SkipNameChars(std::size_t at, bool* foreign) const {
  while (at < text_.size()) {
    if (text::IsNameChar(text_[at])) {
      ++at;
    } else if (AtForeignLetter(at)) {
      *foreign = true;
      at += static_cast<std::size_t>(text::DecodeUtf8(text_, at).bytes);
    } else {
      break;
    }
  }
  return at;
}

void Lexer::LexPath() {
  bool foreign = false;
  std::size_t end = SkipNameChars(at_, &foreign);
  bool bad_part = false;
  while (At(end) == '.' && At(end + 1) != '.') {
    const std::size_t part = end + 1;
    bad_part |= !text::IsLetter(At(part)) && !AtForeignLetter(part);
    end = SkipNameChars(part, &foreign);
  }
  const std::string quoted = text::Concat({"'", text_.substr(at_, end - at_), "'"});
  if (foreign) {
    Report(kBadName, at_, end, quoted + " cannot be a name",
           "names are made of the letters A to Z and a to z, digits and '_'");
  } else if (bad_part) {
    Report(kBadName, at_, end, quoted + " is not a path",
           "a path joins names with single dots: objects.quantity");
  }
  Add(TokenKind::kPath, end, foreign || bad_part);
}

void Lexer::LexNumber() {
  // Takes everything that looks like one number to a person, so that a mistake in it is one error.
  const bool hex = text_[at_] == '0' && (At(at_ + 1) == 'x' || At(at_ + 1) == 'X');
  std::size_t end = at_;
  while (end < text_.size()) {
    const char c = text_[end];
    const char last = end > at_ ? text_[end - 1] : '\0';
    const bool sign = (c == '+' || c == '-') && !hex && (last == 'e' || last == 'E') &&
                      end >= at_ + 2 && text::IsDigit(text_[end - 2]) && text::IsDigit(At(end + 1));
    const bool point = c == '.' && At(end + 1) != '.' && last != '.';
    if (!text::IsNameChar(c) && !AtForeignLetter(end) && !sign && !point) break;
    end += AtForeignLetter(end) ? static_cast<std::size_t>(text::DecodeUtf8(text_, end).bytes) : 1;
  }
  // `benchmark 3d`: the parser reports that it is not a name.
  const bool is_name_like = text_.substr(at_, end - at_).find('.') == std::string_view::npos;
  if (is_name_like && AfterWordBeforeName()) return Add(TokenKind::kNumber, end);
  const bool good = CheckNumber(text_.substr(at_, end - at_), SpanOf(at_, end), diagnostics_);
  Add(TokenKind::kNumber, end, !good);
}

void Lexer::LexText(char quote) {
  const std::size_t begin = at_;
  std::size_t end = begin + 1;
  while (end < text_.size() && text_[end] != quote && text_[end] != '\n') {
    const bool escape = text_[end] == '\\' && end + 1 < text_.size() && text_[end + 1] != '\n' &&
                        text_[end + 1] != '\r';
    end += escape ? 2 : 1;
  }
  const bool closed = end < text_.size() && text_[end] == quote;
  if (!closed) {
    // A character at the end of the line that closes a list or a block was hardly meant as text.
    while (end > begin + 1 &&
           std::string_view(" \t\r{}()[];,").find(text_[end - 1]) != std::string_view::npos)
      --end;
    Report(quote == '"' ? kUnclosedText : kSingleQuotes, begin, begin + 1,
           quote == '"' ? "this text has no closing '\"' on its line"
                        : "a single quote has no meaning here",
           quote == '"' ? "a line break within a text is written \\n" : "a text stands in \"…\"");
    Add(TokenKind::kText, end, true);
    return;
  }
  ++end;
  if (quote == '\'') {
    const std::string inner(text_.substr(begin + 1, end - begin - 2));
    const bool plain = inner.find_first_of("\"\\") == std::string::npos;
    Report(kSingleQuotes, begin, end, "texts are written in double quotes",
           plain ? text::Concat({"write \"", inner, "\", or a word of the language without quotes"})
                 : "");
  } else {
    CheckEscapes(begin + 1, end - 1);
  }
  Add(TokenKind::kText, end, quote == '\'');
}

void Lexer::CheckEscapes(std::size_t begin, std::size_t end) {
  for (std::size_t i = begin; i < end; ++i) {
    if (text::IsControl(text_[i])) {
      Report(kControlCharacter, i, i + 1,
             text::Concat({"a text cannot hold the control character U+",
                           Hex(static_cast<unsigned char>(text_[i]), 4)}));
    }
    if (text_[i] != '\\') continue;
    ++i;
    if (std::string_view("\"\\nt").find(text_[i]) != std::string_view::npos) continue;
    const int bytes = std::max(text::DecodeUtf8(text_, i).bytes, 1);
    const std::size_t stop = text::IsControl(text_[i]) ? i : i + static_cast<std::size_t>(bytes);
    Report(kBadEscape, i - 1, stop,
           text::Concat({"'", text_.substr(i - 1, stop - i + 1), "' is not an escape sequence"}),
           "the escape sequences are \\\" \\\\ \\n and \\t; write \\\\ for a backslash");
  }
}

void Lexer::LexDots() {
  std::size_t end = at_;
  while (At(end) == '.') ++end;
  const bool good = end - at_ == 2;
  if (!good) {
    Report(kForeignOperator, at_, end,
           text::Concat({"'", text_.substr(at_, end - at_), "' has no meaning here"}),
           "did you mean '..'?");
  }
  Add(TokenKind::kDots, end, !good);
}

void Lexer::LexPercent() {
  const std::size_t next = text_.find_first_not_of(" \t", at_ + 1);
  const char c = next == std::string_view::npos ? '\n' : text_[next];
  std::size_t end = next;
  while (end < text_.size() && text::IsNameChar(text_[end])) ++end;
  // After a unit, a value, a range or a comparison may go on.
  constexpr std::string_view kGoesOn[] = {"and",   "or",    "as",    "in", "step",
                                          "count", "sobol", "latin", "log"};
  const bool goes_on =
      end < text_.size() &&
      std::ranges::find(kGoesOn, text_.substr(next, end - next)) != std::end(kGoesOn);
  const bool remainder = !goes_on && (text::IsNameChar(c) || c == '(');
  const TokenKind last = LastKind();
  if (!remainder && (last == TokenKind::kNumber || last == TokenKind::kRightParen)) {
    Add(TokenKind::kPath, at_ + 1);  // a unit
    return;
  }
  Report(kForeignOperator, at_, at_ + 1, "'%' has no meaning here",
         remainder ? "there is no remainder operator; the operators are + - * / ^"
                   : "as a unit, it follows a number or a parenthesis: 5 % is 0.05");
  // Between two values it is an operator; elsewhere it is dropped.
  if (remainder)
    Add(TokenKind::kStar, at_ + 1, true);
  else
    ++at_;
}

bool Lexer::LexForeign() {
  // `!` is an operator itself only if `!=` is not meant.
  if (text_[at_] == '!' && At(at_ + 1) != '=') {
    Report(kForeignOperator, at_, at_ + 1, "'!' has no meaning here", "did you mean 'not'?");
    Add(TokenKind::kNot, at_ + 1, true);
    return true;
  }
  const std::string_view rest = text_.substr(at_);
  if (const ForeignOperator* foreign = FindForeignOperator(rest)) {
    const std::size_t end = at_ + foreign->text.size();
    Report(kForeignOperator, at_, end, text::Concat({"'", foreign->text, "' has no meaning here"}),
           text::Concat({"did you mean '", foreign->here, "'?"}));
    Add(foreign->kind, end, true);
    return true;
  }
  std::size_t quote_bytes = 0;
  if (const std::size_t bytes = ForeignTextBytes(rest, quote_bytes); bytes > 0) {
    Report(kUnknownCharacter, at_, at_ + quote_bytes, "texts are not written in typographic quotes",
           "write \"…\"");
    Add(TokenKind::kText, at_ + bytes, true);
    return true;
  }
  return false;
}

bool Lexer::LexOperator() {
  static constexpr struct {
    std::string_view text;
    TokenKind kind;
  } kOperators[] = {
      {"==", TokenKind::kEqual},       {"!=", TokenKind::kNotEqual},
      {"<=", TokenKind::kLessEqual},   {">=", TokenKind::kGreaterEqual},
      {"<", TokenKind::kLess},         {">", TokenKind::kGreater},
      {"=", TokenKind::kAssign},       {"{", TokenKind::kLeftBrace},
      {"}", TokenKind::kRightBrace},   {"(", TokenKind::kLeftParen},
      {")", TokenKind::kRightParen},   {"[", TokenKind::kLeftBracket},
      {"]", TokenKind::kRightBracket}, {",", TokenKind::kComma},
      {":", TokenKind::kColon},        {";", TokenKind::kSemicolon},
      {"+", TokenKind::kPlus},         {"-", TokenKind::kMinus},
      {"*", TokenKind::kStar},         {"/", TokenKind::kSlash},
      {"^", TokenKind::kCaret},
  };
  for (const auto& entry : kOperators) {
    if (!StartsWith(entry.text)) continue;
    const bool closes =
        entry.kind == TokenKind::kRightParen || entry.kind == TokenKind::kRightBracket;
    // A line can end before the bracket that closes a list.
    if (closes && !result_.tokens.empty() && LastKind() == TokenKind::kNewline)
      result_.tokens.pop_back();
    Add(entry.kind, at_ + entry.text.size());
    return true;
  }
  return false;
}

void Lexer::LexUnknown() {
  const text::CodePoint point = text::DecodeUtf8(text_, at_);
  const std::size_t end = at_ + static_cast<std::size_t>(point.bytes);
  const std::string code = text::Concat({"U+", Hex(static_cast<std::uint32_t>(point.value), 4)});
  if (point.value == '\r') {
    Report(kControlCharacter, at_, end, "carriage return without a line feed",
           "end each line with LF, or with CR LF");
    LexNewline();
    return;
  }
  if (point.value == 0xA0 || (point.value >= 0x2000 && point.value <= 0x200D) ||
      point.value == 0x202F || point.value == 0x3000 || point.value == 0xFEFF) {
    Report(kUnknownCharacter, at_, end, text::Concat({"this is not a plain space but ", code}),
           "replace it by a space");
    at_ = end;
    return;
  }
  if (point.value < 0x20 || point.value == 0x7F) {
    Report(kControlCharacter, at_, end,
           text::Concat({"the control character ", code, " has no meaning here"}));
    at_ = end;
    return;
  }
  const std::string shown(text_.substr(at_, end - at_));
  std::string help;
  if (shown == ".") help = "a range is written 'a .. b', a path 'objects.quantity'";
  Report(kUnknownCharacter, at_, end, text::Concat({"'", shown, "' has no meaning here"}),
         std::move(help));
  Add(TokenKind::kUnknown, end, true);
}

}  // namespace

TokenList Lex(const text::Source& source, Diagnostics& diagnostics) {
  return Lexer(source, diagnostics).Run();
}

std::string TextContents(std::string_view lexeme) {
  const char quote = lexeme.empty() ? '"' : lexeme.front();
  if (!lexeme.empty()) lexeme.remove_prefix(1);
  if (lexeme.ends_with(quote)) lexeme.remove_suffix(1);
  std::string contents;
  for (std::size_t i = 0; i < lexeme.size(); ++i) {
    if (lexeme[i] != '\\' || i + 1 == lexeme.size()) {
      contents += lexeme[i];
      continue;
    }
    const char c = lexeme[++i];
    contents += c == 'n' ? '\n' : c == 't' ? '\t' : c;
  }
  return contents;
}

namespace {

class NumberCheck {
 public:
  NumberCheck(std::string_view lexeme, const text::Span& span, Diagnostics& diagnostics)
      : lexeme_(lexeme), span_(span), diagnostics_(diagnostics) {}

  bool Run() {
    const bool is_hex = lexeme_.starts_with("0x") || lexeme_.starts_with("0X");
    if (!TakeDigits(is_hex)) return false;
    if (is_hex) return CheckHex();
    if (digits_.front() == '.')
      return Refuse(kBadNumber, "a number must begin with a digit",
                    text::Concat({"write 0", lexeme_}));
    if (digits_.back() == '.')
      return Refuse(kBadNumber, "a number cannot end with a point",
                    text::Concat({"write ", lexeme_, "0, or leave the point out"}));
    return CheckDecimal();
  }

 private:
  bool Refuse(const DiagnosticKind& kind, std::string message, std::string help) {
    diagnostics_.Report(kind, span_, std::move(message), std::move(help));
    return false;
  }
  std::string Quoted() const { return text::Concat({"'", lexeme_, "'"}); }
  bool RefuseForm(std::string help) {
    return Refuse(kBadNumber, Quoted() + " is not a number", std::move(help));
  }

  /// Appends digits to `digits_`, without the underscores.
  bool TakeDigits(bool is_hex) {
    const auto is_digit = is_hex ? text::IsHexDigit : text::IsDigit;
    for (std::size_t i = 0; i < lexeme_.size(); ++i) {
      if (lexeme_[i] != '_') {
        digits_ += lexeme_[i];
        continue;
      }
      if (i == 0 || i + 1 == lexeme_.size() || !is_digit(lexeme_[i - 1]) ||
          !is_digit(lexeme_[i + 1]))
        return RefuseForm("'_' is only allowed between two digits: 1_000");
    }
    return true;
  }

  bool CheckHex() {
    const char *begin = digits_.data() + 2, *end = digits_.data() + digits_.size();
    std::uint64_t value = 0;
    const auto [stop, error] = std::from_chars(begin, end, value, 16);
    if (stop != end || stop == begin)
      return RefuseForm("0x must be followed by the digits 0 to 9 and A to F, without a point");
    if (error == std::errc::result_out_of_range)
      return Refuse(kNumberRange, Quoted() + " does not fit into 64 bits",
                    "the largest is 0xFFFFFFFFFFFFFFFF");
    return true;
  }

  bool SkipDigits(std::size_t& at) const {
    const std::size_t from = at;
    while (at < digits_.size() && text::IsDigit(digits_[at])) ++at;
    return at > from;
  }

  /// Skips digits, a point between digits, and an exponent with digits. Nullopt if one of these is
  /// incomplete, otherwise whether the number is an integer.
  std::optional<bool> SkipDecimal(std::size_t& at) const {
    const auto has = [&](std::string_view any) {
      return at < digits_.size() && any.find(digits_[at]) != std::string_view::npos;
    };
    bool is_whole = true;
    SkipDigits(at);
    if (has(".")) {
      is_whole = false;
      ++at;
      if (!SkipDigits(at)) return std::nullopt;
    }
    if (has("eE")) {
      is_whole = false;
      ++at;
      if (has("+-")) ++at;
      if (!SkipDigits(at)) return std::nullopt;
    }
    return is_whole;
  }

  bool CheckDecimal() {
    std::size_t at = 0;
    const std::optional<bool> is_whole = SkipDecimal(at);
    if (!is_whole) return RefuseForm("");
    if (at < digits_.size()) {
      const std::string_view rest = std::string_view(digits_).substr(at);
      const std::string_view unit = text::IsUnitName(rest) ? rest : text::UnitCalled(rest);
      return RefuseForm(unit.empty() ? ""
                                     : text::Concat({"write a space before the unit: ",
                                                     digits_.substr(0, at), " ", unit}));
    }
    return *is_whole ? CheckWholeRange() : CheckRealRange();
  }

  template <typename Number>
  bool Fits() const {
    Number value = 0;
    return std::from_chars(digits_.data(), digits_.data() + digits_.size(), value).ec !=
           std::errc::result_out_of_range;
  }
  bool CheckWholeRange() {
    return Fits<std::uint64_t>() ||
           Refuse(kNumberRange, Quoted() + " does not fit into 64 bits",
                  "if a rounded number is enough, write it with an exponent: 1e20");
  }
  bool CheckRealRange() {
    return Fits<double>() || Refuse(kNumberRange, Quoted() + " does not fit into a 64-bit real",
                                    "reals range from about 1e-308 to 1.8e308");
  }

  std::string_view lexeme_;
  const text::Span& span_;
  Diagnostics& diagnostics_;
  std::string digits_;
};

}  // namespace

bool CheckNumber(std::string_view lexeme, const text::Span& span, Diagnostics& diagnostics) {
  return NumberCheck(lexeme, span, diagnostics).Run();
}

}  // namespace cdb::dsl
