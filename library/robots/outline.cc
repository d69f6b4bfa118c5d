#include "library/robots/outline.h"

#include <fmt/format.h>

#include <algorithm>

#include "dsl/text/utf8.h"
#include "library/scene_error.h"

namespace cdb::robots {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

bool IsNameCharacter(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == ':' || c == '-' || c == '.' || byte >= 0x80;
}

bool IsUtf8(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const int bytes = text::DecodeUtf8(text, at).bytes;
    if (bytes == 0) return false;
    at += static_cast<std::size_t>(bytes);
  }
  return true;
}

class Scanner {
 public:
  Scanner(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  std::vector<Element> Read() {
    while (at_ < text_.size()) {
      const std::size_t next = std::min(text_.find('<', at_), text_.size());
      if (open_.empty() && text_.substr(at_, next - at_).find_first_not_of(kBlanks) != text_.npos &&
          !(at_ == 0 && text_.starts_with("\xef\xbb\xbf")))
        Fail(at_, "text outside of the elements", "is it an XML file?");
      at_ = next;
      if (at_ < text_.size()) Markup();
    }
    if (!open_.empty())
      Fail(elements_[open_.back()].begin,
           fmt::format("<{}> is not closed", elements_[open_.back()].name),
           "the file may be cut off");
    return std::move(elements_);
  }

 private:
  [[noreturn]] void Fail(std::size_t at, const std::string& cause, const std::string& remedy) {
    throw library::SceneError(fmt::format("{}:{}: {}", file_, LineOf(at), cause), remedy);
  }

  std::size_t LineOf(std::size_t at) {
    if (at < counted_) counted_ = 0, line_ = 1;
    line_ +=
        static_cast<std::size_t>(std::ranges::count(text_.substr(counted_, at - counted_), '\n'));
    counted_ = at;
    return line_;
  }

  /// Past the next `end`.
  void SkipPast(std::string_view end, const char* what) {
    const std::size_t found = text_.find(end, at_);
    if (found == text_.npos)
      Fail(at_, fmt::format("{} does not end", what), "the file may be cut off");
    at_ = found + end.size();
  }

  void Markup() {
    const std::string_view rest = text_.substr(at_);
    if (rest.starts_with("<!--")) {
      at_ += 4;
      return SkipPast("-->", "a comment");
    }
    if (rest.starts_with("<![CDATA[")) return SkipPast("]]>", "a CDATA section");
    if (rest.starts_with("<!"))
      Fail(at_, "a document type or an entity is declared", "remove it: robots need none");
    if (rest.starts_with("<?")) return SkipPast("?>", "a declaration");
    if (rest.starts_with("</")) return EndTag();
    StartTag();
  }

  std::string Name() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && IsNameCharacter(text_[at_])) ++at_;
    if (at_ == begin) Fail(begin, "a name is missing", "in a text, write &lt; for <");
    return std::string(text_.substr(begin, at_ - begin));
  }

  void SkipBlanks() { at_ = std::min(text_.find_first_not_of(kBlanks, at_), text_.size()); }

  void EndTag() {
    const std::size_t begin = at_;
    at_ += 2;
    const std::string name = Name();
    SkipBlanks();
    if (at_ == text_.size() || text_[at_] != '>')
      Fail(begin, fmt::format("</{}> does not end", name), "write '>' after the name");
    ++at_;
    if (open_.empty()) Fail(begin, fmt::format("</{}> closes nothing", name), "remove it");
    Element& element = elements_[open_.back()];
    if (element.name != name)
      Fail(begin,
           fmt::format("</{}> does not close <{}> of line {}", name, element.name, element.line),
           fmt::format("write </{}> before it", element.name));
    element.end = at_;
    open_.pop_back();
  }

  void StartTag() {
    const std::size_t begin = at_;
    ++at_;
    Element element;
    element.begin = begin;
    element.line = LineOf(begin);
    element.name = Name();
    if (open_.empty() && !elements_.empty())
      Fail(begin, fmt::format("<{}> is a second root element", element.name),
           "one file is one robot");
    if (!open_.empty()) element.parent = open_.back();
    if (open_.size() >= kMaxDepth)
      Fail(begin, fmt::format("elements are nested more than {} deep", kMaxDepth),
           "no robot needs that");
    if (elements_.size() >= kMaxElements)
      Fail(begin, fmt::format("there are more than {} elements", kMaxElements), "");
    for (;;) {
      SkipBlanks();
      if (at_ == text_.size())
        Fail(begin, fmt::format("<{}> does not end", element.name), "the file may be cut off");
      if (text_[at_] == '>' || text_.substr(at_).starts_with("/>")) break;
      ReadAttribute(element);
    }
    const bool is_empty = text_[at_] == '/';
    at_ += is_empty ? 2 : 1;
    element.end = at_;
    if (!is_empty) open_.push_back(elements_.size());
    elements_.push_back(std::move(element));
  }

  void ReadAttribute(Element& element) {
    const std::size_t begin = at_;
    std::string name = Name();
    SkipBlanks();
    if (at_ == text_.size() || text_[at_] != '=')
      Fail(begin, fmt::format("the attribute {} has no value", name),
           fmt::format("write {}=\"…\"", name));
    ++at_;
    SkipBlanks();
    if (at_ == text_.size() || (text_[at_] != '"' && text_[at_] != '\''))
      Fail(begin, fmt::format("the value of {} is not in quotes", name),
           fmt::format("write {}=\"…\"", name));
    const std::size_t end = text_.find(text_[at_], at_ + 1);
    if (end == text_.npos)
      Fail(begin, fmt::format("the value of {} does not end", name), "a quote is missing");
    if (text_.substr(at_, end - at_).find('<') != text_.npos)
      Fail(begin, fmt::format("the value of {} contains '<'", name),
           "a quote may be missing; in a value, write &lt; for <");
    if (!element.Attribute(name).empty())
      Fail(begin, fmt::format("<{}> has two values of {}", element.name, name), "keep one of them");
    element.attributes.emplace_back(std::move(name), text_.substr(at_ + 1, end - at_ - 1));
    at_ = end + 1;
  }

  std::string_view text_;
  const std::string& file_;
  std::size_t at_ = 0;
  std::size_t counted_ = 0, line_ = 1;  ///< the line at byte `counted_`
  std::vector<Element> elements_;
  std::vector<std::size_t> open_;
};

}  // namespace

std::string_view Element::Attribute(std::string_view attribute) const {
  const auto found =
      std::ranges::find(attributes, attribute, [](const auto& pair) { return pair.first; });
  return found == attributes.end() ? std::string_view() : found->second;
}

std::vector<Element> ReadOutline(std::string_view text, const std::string& file) {
  if (text.size() > kMaxRobotBytes)
    throw library::SceneError(fmt::format("{}: has {} MiB, more than the {} of a robot", file,
                                          text.size() >> 20, kMaxRobotBytes >> 20),
                              "meshes belong into files of their own");
  if (text.find('\0') != text.npos || !IsUtf8(text))
    throw library::SceneError(fmt::format("{}: is not text in UTF-8", file), "save it as UTF-8");
  return Scanner(text, file).Read();
}

}  // namespace cdb::robots
