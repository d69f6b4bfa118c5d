#include "tests/dsl/random_text.h"

#include <algorithm>
#include <iterator>
#include <vector>

namespace cdb::tests {
namespace {

// Joins pieces without operator+ on temporaries, for which GCC 12 gives a false warning.
std::string Join(std::initializer_list<std::string_view> pieces) {
  std::string joined;
  for (const std::string_view piece : pieces) joined += piece;
  return joined;
}

std::string Indent(int level) { return std::string(static_cast<std::size_t>(2 * level), ' '); }

}  // namespace

std::string RandomText::Space() {
  static constexpr std::string_view kSpaces[] = {"", "", " ", " ", "  ", "\t"};
  return std::string(kSpaces[Below(std::size(kSpaces))]);
}

// At least one space.
std::string RandomText::Gap() { return OneIn(4) ? "\t  " : " "; }

// White space where a line may break inside brackets.
std::string RandomText::Break() {
  if (!OneIn(8)) return Space();
  return OneIn(3) ? "  # within a list\n   " : OneIn(2) ? "\n\n\t" : "\r\n ";
}

std::string RandomText::LineEnd() {
  switch (Below(8)) {
    case 0:
      return "\n\n\n";
    case 1:
      return "  # a comment, with } and \"\n";
    case 2:
      return "\r\n";
    case 3:
      return " ; ";
    case 4:
      return "\n  \t# alone\n";
    default:
      return "\n";
  }
}

std::string RandomText::Name() {
  static constexpr std::string_view kNames[] = {"a",    "quantity", "size", "step",     "count",
                                                "log",  "as_of",    "n2",   "_x",       "when",
                                                "from", "on",       "dbvt", "detector", "sphere"};
  return std::string(kNames[Below(std::size(kNames))]);
}

std::string RandomText::Number() {
  static constexpr std::string_view kNumbers[] = {
      "0", "1", "50", "9.8", "1e6", "1E-3", "2.5e+10", "1_000_000", "0xAA_BB", "0x1e", "3_0.0_1"};
  return std::string(kNumbers[Below(std::size(kNumbers))]);
}

std::string RandomText::Text(std::string* dump) {
  static constexpr std::string_view kTexts[] = {
      "", "plain", "a # b", "caf\u00e9", "{ ; } ,", "\\\"x\\\" \\\\", "two\\nlines\\tand a tab"};
  // The tree does not distinguish an empty title from none, so the empty text is used for values
  // only.
  const std::string text = Join({"\"", kTexts[1 + Below(std::size(kTexts) - 1)], "\""});
  *dump = text;
  return text;
}

RandomText::Piece RandomText::Call(int depth) {
  Piece call;
  const std::string name = Name();
  call.text = Join({name, Space(), "(", Break()});
  call.dump = Join({"(call ", name});
  const int count = Below(4);
  for (int i = 0; i < count; ++i) {
    if (i > 0) call.text += Join({Space(), ",", Break()});
    call.dump += ' ';
    const bool labelled = OneIn(5);
    if (labelled) {
      const std::string label = Name();
      call.text += Join({label, Space(), ":", Space()});
      call.dump += Join({label, ":"});
    }
    if (OneIn(5)) {
      Piece choice{Name(), "", kPrimary};
      choice.dump = choice.text;
      if (depth > 1 && OneIn(2)) choice = Call(depth - 1);
      const std::string weight = Number();
      call.text += Join({choice.text, Gap(), weight});
      call.dump += Join({"(weigh ", choice.dump, " ", weight, ")"});
    } else {
      const Piece value = labelled ? Value(depth - 1) : ValueOrBareCall(depth - 1);
      call.text += value.text;
      call.dump += value.dump;
    }
  }
  call.text += count > 0 ? Break() : "";
  call.text += ')';
  if (OneIn(5)) {
    const std::string axis = Name();
    std::string title;
    const std::string text = OneIn(2) ? Text(&title) : "";
    const bool has_name = text.empty() || OneIn(2);
    call.text += Join({Space(), "as"});
    if (has_name) call.text += Join({Gap(), axis});
    if (!text.empty()) call.text += Join({Space(), text});
    if (has_name) call.dump += Join({" as ", axis});
    if (!title.empty()) call.dump += Join({" titled ", title});
  }
  if (OneIn(6)) {
    const std::string least = Number(), most = Number();
    // The upper limit would include the rest of a sum.
    call.level = 0;
    call.text += Join({Gap(), "in", Gap(), least, Space(), "..", Space(), most});
    call.dump += Join({" in ", least, " ", most});
  }
  call.dump += ')';
  return call;
}

RandomText::Piece RandomText::Primary(int depth) {
  switch (depth <= 0 ? Below(2) : Below(6)) {
    case 0: {
      const std::string number = Number();
      return {number, number, kPrimary};
    }
    case 1: {
      const std::string path = OneIn(4) ? Join({Name(), ".", Name()}) : Name();
      return {path, path, kPrimary};
    }
    case 2: {
      const Piece x = Expr(depth - 1), y = Expr(depth - 1), z = Expr(depth - 1);
      return {
          Join({"(", Break(), x.text, ",", Break(), y.text, Space(), ",", z.text, Break(), ")"}),
          Join({"(vector ", x.dump, " ", y.dump, " ", z.dump, ")"}), kPrimary};
    }
    case 3: {
      const Piece inner = Expr(depth - 1);
      return {Join({"(", Space(), inner.text, Space(), ")"}), inner.dump, kPrimary};
    }
    default:
      return Call(depth);
  }
}

// `5 cm`, `1/60 s`, `(a + b) m/s^2`.
RandomText::Piece RandomText::Quantity(int depth) {
  Piece value;
  const std::string number = Number();
  if (OneIn(2)) {
    value = {number, number, kPrimary};
  } else if (OneIn(2)) {
    const std::string divisor = Number();
    value = {Join({number, Space(), "/", Space(), divisor}),
             Join({"(/ ", number, " ", divisor, ")"}), kProduct};
  } else {
    const Piece inner = Expr(depth - 1);
    value = {Join({"(", inner.text, Space(), ")"}), inner.dump, kPrimary};
  }
  static constexpr std::string_view kUnits[] = {"cm", "ms", "kg", "deg"};
  std::string unit(kUnits[Below(std::size(kUnits))]), written = unit;
  if (OneIn(3)) {
    unit += "/s^2";
    written += Join({Space(), "/", Space(), "s", Space(), "^", Space(), "2"});
  }
  return {Join({value.text, Gap(), written}), Join({"(unit ", value.dump, " ", unit, ")"}),
          kProduct};
}

RandomText::Piece RandomText::Expr(int depth) {
  if (depth <= 0 || OneIn(3)) return Primary(depth);
  if (OneIn(8)) return Quantity(depth);
  if (OneIn(4)) {
    const Piece operand = At(kPrimary, depth - 1);
    return {Join({"-", Space(), operand.text}), Join({"(neg ", operand.dump, ")"}), kUnary};
  }
  const char op = "+-*/^"[Below(5)];
  const int level = op == '^' ? kPower : op == '*' || op == '/' ? kProduct : kSum;
  // `^` is right-associative, the others are left-associative.
  const Piece left = At(op == '^' ? kUnary : level, depth - 1);
  const Piece right = At(op == '^' ? kPower : level + 1, depth - 1);
  const std::string sign(1, op);
  return {Join({left.text, Space(), sign, Space(), right.text}),
          Join({"(", sign, " ", left.dump, " ", right.dump, ")"}), level};
}

// An expression that is valid where `level` is expected, with brackets if necessary.
RandomText::Piece RandomText::At(int level, int depth) {
  Piece piece = Expr(depth);
  if (piece.level >= level) return piece;
  return {Join({"(", piece.text, ")"}), piece.dump, kPrimary};
}

RandomText::Piece RandomText::Range(int depth) {
  const Piece first = Expr(depth), last = Expr(depth);
  Piece range{Join({first.text, Space(), "..", Space(), last.text}), "", kSum};
  std::string word = "range", third;
  if (!OneIn(3)) {
    const Piece by = Expr(depth);
    static constexpr std::string_view kForms[] = {"step", "count", "sobol", "latin"};
    const int form = Below(4);
    range.text += Join({Gap(), kForms[form], Gap(), by.text});
    word = Join({"range-", kForms[form]});
    if (form > 0 && OneIn(2)) {
      range.text += Join({Gap(), "log"});
      word += "-log";
    }
    third = Join({" ", by.dump});
  }
  range.dump = Join({"(", word, " ", first.dump, " ", last.dump, third, ")"});
  return range;
}

RandomText::Piece RandomText::Value(int depth) {
  switch (Below(8)) {
    case 0: {
      Piece text;
      text.text = Text(&text.dump);
      return text;
    }
    case 1: {
      const Piece x = Expr(depth), y = Expr(depth), z = Expr(depth);
      return {Join({x.text, Space(), ":", Space(), y.text, Space(), ":", Space(), z.text}),
              Join({"(ratio ", x.dump, " ", y.dump, " ", z.dump, ")"}), kSum};
    }
    case 2:
      return Range(depth);
    default:
      return Expr(depth);
  }
}

RandomText::Piece RandomText::ValueOrBareCall(int depth) {
  if (!OneIn(6)) return Value(depth);
  const std::string name = Name(), label = Name();
  const Piece argument = Value(depth);
  return {Join({name, Gap(), label, Space(), ":", Space(), argument.text}),
          Join({"(call ", name, " ", label, ":", argument.dump, ")"}), kSum};
}

RandomText::Piece RandomText::Operand(int depth) {
  if (depth > 0 && OneIn(3)) {
    const Piece inner = Condition(depth - 1);
    return {Join({"(", Space(), inner.text, Space(), ")"}), inner.dump, kPrimary};
  }
  static constexpr std::string_view kSigns[] = {"==", "!=", "<", "<=", ">", ">="};
  const std::string_view sign = kSigns[Below(std::size(kSigns))];
  const Piece left = Expr(1), right = Expr(1);
  return {Join({left.text, Space(), sign, Space(), right.text}),
          Join({"(", sign, " ", left.dump, " ", right.dump, ")"}), kPrimary};
}

RandomText::Piece RandomText::Condition(int depth) {
  if (depth > 0 && OneIn(5)) {
    const Piece inner = Condition(depth - 1);  // `not` applies to the whole condition
    return {Join({"not", Gap(), inner.text}), Join({"(not ", inner.dump, ")"}), kPrimary};
  }
  Piece whole;
  const int ands = 1 + Below(2);
  for (int i = 0; i < ands; ++i) {
    Piece part = Operand(depth);
    for (int more = Below(3); more > 0; --more) {
      const Piece next = Operand(depth);
      part.text += Join({Gap(), "and", Gap(), next.text});
      part.dump = Join({"(and ", part.dump, " ", next.dump, ")"});
    }
    if (i == 0) {
      whole = part;
    } else {
      whole.text += Join({Gap(), "or", Gap(), part.text});
      whole.dump = Join({"(or ", whole.dump, " ", part.dump, ")"});
    }
  }
  return whole;
}

void RandomText::Block(int level, int depth, Sample& out) {
  out.dump += '\n';
  out.text += Join({Space(), "{", OneIn(3) ? " # opens\n" : Space()});
  const int count = Below(5);
  for (int i = 0; i < count; ++i) Statement(level + 1, depth, out);
  out.text += OneIn(4) ? "\n}" : "}";
}

void RandomText::Statement(int level, int depth, Sample& out) {
  if (OneIn(2)) out.text += Indent(level);
  out.dump += Indent(level);
  const int choice = depth > 0 ? Below(9) : 3 + Below(6);
  if (choice == 0) {
    const std::string name = Name();
    out.text += Join({"objects", Gap(), name});
    out.dump += Join({"group objects ", name});
    Block(level, depth - 1, out);
  } else if (choice == 1) {
    out.text += "world";
    out.dump += "group world";
    Block(level, depth - 1, out);
  } else if (choice == 2) {
    out.text += "cases load {";
    out.dump += "cases load\n";
    for (int i = Below(3); i > 0; --i) {
      std::string title;
      out.text += Join({"calm", Gap(), Text(&title)});
      out.dump += Join({Indent(level + 1), "case calm ", title});
      Block(level + 1, depth - 1, out);
      out.text += OneIn(2) ? "\n" : " ";
    }
    out.text += '}';
  } else if (choice == 3) {
    const std::string name = Name();
    const Piece value = ValueOrBareCall(2);
    out.text += Join({"let", Gap(), name, Space(), "=", Space(), value.text});
    out.dump += Join({"let ", name, " ", value.dump, "\n"});
  } else if (choice == 4) {
    const Piece when = Condition(2);
    out.text += Join({"skip when", Gap(), when.text});
    out.dump += Join({"skip ", when.dump, "\n"});
  } else {
    const std::string path = OneIn(3) ? Join({Name(), ".", Name()}) : Name();
    out.text += Join({path, Gap()});
    out.dump += Join({"set ", path});
    for (int i = Below(3); i >= 0; --i) {
      // If another value follows, `, a :` would be a second argument.
      const Piece value = i > 0 ? Value(3) : ValueOrBareCall(3);
      out.text += Join({value.text, i > 0 ? Space() : "", i > 0 ? "," : "", i > 0 ? Break() : ""});
      out.dump += Join({" ", value.dump});
    }
    out.dump += '\n';
  }
  out.text += LineEnd();
}

RandomText::Sample RandomText::File() {
  Sample out;
  if (OneIn(10)) out.text += "\xEF\xBB\xBF";
  if (OneIn(3)) out.text += "# at the top\n\n";
  for (int i = Below(4); i >= 0; --i) {
    std::string text;
    if (OneIn(4)) {
      const bool detector = OneIn(2);
      const std::string path = Text(&text);
      out.text += Join({"use ", detector ? "detector " : "", path, LineEnd()});
      out.dump += Join({"use ", detector ? "detector " : "", text, "\n"});
      continue;
    }
    out.text += "benchmark b";
    out.dump += "benchmark b";
    if (OneIn(3)) {
      out.text += " from base";
      out.dump += " from base";
    }
    if (OneIn(2)) {
      out.text += Join({Space(), Text(&text)});
      out.dump += Join({" ", text});
    }
    Block(0, 3, out);
    out.text += LineEnd();
  }
  return out;
}

std::string RandomText::Soup() {
  static constexpr std::string_view kTokens[] = {
      "benchmark", "use",    "let",    "cases",
      "skip",      "when",   "from",   "as",
      "step",      "count",  "log",    "and",
      "or",        "not",    "size",   "a.b",
      "a.",        ".",      "..",     "...",
      "5",         "1e9",    "0x",     "1_",
      "\"t\"",     "\"u",    "'v'",    "{",
      "{",         "}",      "}",      "(",
      "(",         ")",      ")",      "[",
      "]",         ",",      ":",      ";",
      "=",         "==",     "!=",     "<",
      ">=",        "+",      "-",      "*",
      "/",         "^",      "%",      "&&",
      "||",        "!",      "//",     "/*",
      "*/",        "#",      "\n",     "\n",
      "\n",        "\r\n",   "\r",     "\t",
      " ",         " ",      " ",      " ",
      "@",         "\u00e9", "\u2212", "\x01",
      "\u201c",    "sweep(", "any(",   "\nbenchmark b {\n",
      "\u7530",    "cm",     "m/s^2"};
  std::string soup;
  for (int i = Below(60); i > 0; --i) {
    soup += kTokens[Below(std::size(kTokens))];
    if (OneIn(2)) soup += ' ';
  }
  return soup;
}

std::string RandomText::Mutate(std::string text) {
  for (int i = 1 + Below(4); i > 0 && !text.empty(); --i) {
    const std::size_t at = engine_() % text.size();
    const std::size_t length = std::min<std::size_t>(1 + engine_() % 12, text.size() - at);
    switch (Below(7)) {
      case 0:
        text.erase(at, length);
        break;
      case 1:
        text.insert(at, text.substr(at, length));
        break;
      case 2:
        text[at] = static_cast<char>(engine_() % 256);
        break;
      case 3:
        text[at] = "{}()[],;:=\"'.#\n-+x0"[Below(19)];
        break;
      case 4:
        text.insert(at, text.substr(engine_() % text.size(), length));
        break;
      case 5:
        text.insert(at, Soup());
        break;
      default:
        std::swap(text[at], text[engine_() % text.size()]);
    }
  }
  return text;
}

}  // namespace cdb::tests
