#include "runtime/editor/server.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "runtime/editor/message_stream.h"
#include "tests/runtime/editor/client.h"

namespace cdb::tests {
namespace {

const char kUri[] = "file:///t/a.cdb";

std::set<std::string> Labels(const Json& items) {
  std::set<std::string> labels;
  for (const Json& item : items) labels.insert(item["label"]);
  return labels;
}

Json Range(int line, int begin, int end) {
  return {{"start", {{"line", line}, {"character", begin}}},
          {"end", {{"line", line}, {"character", end}}}};
}

TEST(MessageReader, CutsMessagesHoweverTheyArrive) {
  const std::string bytes = editor::Framed("{\"a\":1}") + "content-length: 2\r\nX: y\r\n\r\n[]" +
                            "no length at all\r\n\r\n" + "Content-Length: x\r\n\r\n" +
                            editor::Framed("last");
  for (std::size_t step = 1; step < bytes.size(); ++step) {
    editor::MessageReader reader;
    std::vector<std::string> messages;
    for (std::size_t at = 0; at < bytes.size(); at += step) {
      reader.Add(std::string_view(bytes).substr(at, step));
      while (const auto message = reader.Next()) messages.push_back(*message);
    }
    EXPECT_EQ(messages, (std::vector<std::string>{"{\"a\":1}", "[]", "last"})) << step;
  }
  editor::MessageReader endless;
  endless.Add("Content-Length: 99999999999\r\n\r\n");
  EXPECT_FALSE(endless.Next());
  EXPECT_TRUE(endless.is_broken());
  editor::MessageReader no_head;
  no_head.Add(std::string(10000, 'x'));
  EXPECT_FALSE(no_head.Next());
  EXPECT_TRUE(no_head.is_broken());
}

TEST(Positions, CountUtf16) {
  // é is two bytes and one unit; 😀 is four bytes and two units; a byte that is not UTF-8 is one
  // unit.
  const text::Source source("t", "ab\n\xC3\xA9\xF0\x9F\x98\x80z\r\n\xE9y");
  const auto at = [&](std::uint32_t offset) {
    const editor::Position position = editor::PositionOf(source, offset);
    return std::pair(position.line, position.character);
  };
  using Place = std::pair<std::int64_t, std::int64_t>;
  EXPECT_EQ(at(0), Place(0, 0));
  EXPECT_EQ(at(3), Place(1, 0));
  EXPECT_EQ(at(5), Place(1, 1));
  EXPECT_EQ(at(7), Place(1, 1));  // within the character
  EXPECT_EQ(at(9), Place(1, 3));
  EXPECT_EQ(at(13), Place(2, 1));
  EXPECT_EQ(editor::OffsetOf(source, {1, 3}), 9u);
  EXPECT_EQ(editor::OffsetOf(source, {1, 2}), 5u);    // between the halves
  EXPECT_EQ(editor::OffsetOf(source, {1, 99}), 10u);  // before the line end
  EXPECT_EQ(editor::OffsetOf(source, {99, 0}), source.text().size());
  EXPECT_EQ(editor::OffsetOf(source, {-1, 5}), 0u);
  EXPECT_EQ(editor::OffsetOf(source, {0, -5}), 0u);
  for (std::uint32_t i = 0; i <= source.text().size(); ++i)
    EXPECT_LE(editor::OffsetOf(source, editor::PositionOf(source, i)), i);
}

TEST(Positions, PathsAndAddresses) {
  EXPECT_EQ(editor::PathOf("file:///tmp/a%20b%C3%A9.cdb"), "/tmp/a b\xC3\xA9.cdb");
  EXPECT_EQ(editor::PathOf("file:///tmp/%zz%4"), "/tmp/%zz%4");
  EXPECT_EQ(editor::PathOf("untitled:Untitled-1"), "untitled:Untitled-1");
  EXPECT_EQ(editor::UriOf("/tmp/a b.cdb"), "file:///tmp/a%20b.cdb");
  EXPECT_EQ(editor::PathOf(editor::UriOf("/tmp/#?%.cdb")), "/tmp/#?%.cdb");
}

TEST(Server, DiagnosticsFollowWhatIsTyped) {
  Client client;
  client.Open(kUri, "# \xF0\x9F\x98\x80 caf\xC3\xA9\nbenchmark b { /*\xF0\x9F\x98\x80*/ }\n");
  EXPECT_EQ(client.Diagnostics(kUri).size(), 1u);
  EXPECT_TRUE(client.Diagnostics(kUri).is_null()) << "published twice";
  // After a character of two units.
  client.Tell("textDocument/didChange",
              {{"textDocument", {{"uri", kUri}, {"version", 2}}},
               {"contentChanges",
                {{{"range", Range(1, 14, 20)}, {"text", "objects.type \xC3\xA9"}},
                 {{"range", Range(1, 27, 28)}, {"text", "cuboyd"}}}}});
  const Json diagnostics = client.Diagnostics(kUri);
  ASSERT_EQ(diagnostics.size(), 1u) << diagnostics;
  EXPECT_EQ(diagnostics[0]["range"], Range(1, 27, 33));
  EXPECT_EQ(diagnostics[0]["code"], "E0201");
  EXPECT_EQ(diagnostics[0]["severity"], 1);
  EXPECT_EQ(diagnostics[0]["message"], "'type' cannot be 'cuboyd'\ndid you mean 'cuboid'?");
  client.Tell("textDocument/didChange", {{"textDocument", {{"uri", kUri}, {"version", 3}}},
                                         {"contentChanges", {{{"text", "benchmark b { }\n"}}}}});
  EXPECT_EQ(client.Diagnostics(kUri), Json::array());
  client.Tell("textDocument/didClose", {{"textDocument", {{"uri", kUri}}}});
  EXPECT_EQ(client.sent.back()["params"]["diagnostics"], Json::array());
}

TEST(Server, TypingCompilesOnlyWhenItRests) {
  Client client;
  client.Open(kUri, "benchmark b { }\n");
  for (int i = 0; i < 20; ++i)
    client.Tell("textDocument/didChange",
                {{"textDocument", {{"uri", kUri}, {"version", i + 2}}},
                 {"contentChanges", {{{"range", Range(0, 14, 14)}, {"text", " "}}}}});
  EXPECT_EQ(client.compilations(), 0);
  client.Diagnostics(kUri);
  client.At("hover", kUri, 0, 2);
  EXPECT_EQ(client.compilations(), 1);
}

TEST(Server, AFaultInAUsedFileStandsAtItsUse) {
  Client client;
  client.files["/t/base.cdb"] = "let n = 1 / 0\nbenchmark a { colour red }\n";
  client.Open(kUri, "# one\nuse \"base\"\nbenchmark b from a { cycles n }\n");
  const Json diagnostics = client.Diagnostics(kUri);
  ASSERT_FALSE(diagnostics.empty());
  for (const Json& one : diagnostics) {
    EXPECT_EQ(one["range"], Range(1, 0, 10)) << one;
    EXPECT_EQ(one["message"].get<std::string>().find("/t/base.cdb:"), 0u) << one;
  }
}

TEST(Server, CompletesWhatMayStandThere) {
  Client client;
  client.Open(kUri,
              "let n = 5\nbenchmark b {\n  \n  detector sweep(sa\n  world { si }\n"
              "  objects { type any(sp\n  location ring(\n  }\n  skip when detector == \n}\n"
              "benchmark c from \nuse \"\n");
  const auto labels = [&](int line, int character) {
    return Labels(client.At("completion", kUri, line, character));
  };
  const auto statement = labels(2, 2);
  for (const char* word :
       {"cycles", "objects", "world", "skip", "cases", "let", "world.side", "objects.size"})
    EXPECT_TRUE(statement.contains(word)) << word;
  EXPECT_FALSE(statement.contains("size"));
  const auto detectors = labels(3, 19);
  EXPECT_TRUE(detectors.contains("sap32"));
  EXPECT_TRUE(detectors.contains("n"));
  EXPECT_FALSE(detectors.contains("sphere"));
  EXPECT_FALSE(detectors.contains("uniform"));
  EXPECT_EQ(labels(4, 12).count("side"), 1u);
  EXPECT_EQ(labels(4, 12).count("cycles"), 0u);
  const auto types = labels(5, 23);
  EXPECT_TRUE(types.contains("sphere"));
  EXPECT_TRUE(types.contains("mesh"));
  EXPECT_TRUE(labels(6, 16).contains("radius:"));
  EXPECT_TRUE(labels(8, 24).contains("dbvt"));
  EXPECT_EQ(labels(10, 17), (std::set<std::string>{"b", "c"}));
  EXPECT_TRUE(labels(0, 8).contains("sweep"));
  EXPECT_TRUE(labels(0, 8).contains("find"));
  EXPECT_EQ(labels(0, 0), (std::set<std::string>{"benchmark", "let", "use"}));
  // The word being typed is replaced as a whole.
  for (const Json& item : client.At("completion", kUri, 3, 19))
    EXPECT_EQ(item["textEdit"]["range"], Range(3, 17, 19));
}

TEST(Server, CompletesAfterADot) {
  Client client;
  client.Open(kUri, "benchmark b {\n  world.\n  objects { links.t }\n  cycles 1..\n}\nlet = 5\n");
  const Json items = client.At("completion", kUri, 1, 8);
  EXPECT_TRUE(Labels(items).contains("world.side"));
  EXPECT_EQ(items[0]["textEdit"]["range"], Range(1, 2, 8));
  EXPECT_TRUE(Labels(client.At("completion", kUri, 2, 19)).contains("links.type"));
  EXPECT_FALSE(client.At("completion", kUri, 3, 12).is_null());
  EXPECT_TRUE(client.At("references", kUri, 5, 2).empty());
}

TEST(Server, HoversShowTheManual) {
  Client client;
  client.Open(kUri,
              "let n = 5\nbenchmark b \"t\" {\n  cycles n\n  detector sweep(sap, dbvt)\n"
              "  objects { size 5 }\n}\n");
  const auto text = [&](int line, int character) -> std::string {
    const Json hover = client.At("hover", kUri, line, character);
    return hover.is_null() ? "" : hover["contents"]["value"].get<std::string>();
  };
  EXPECT_NE(text(2, 4).find("collision-detection cycles to time"), std::string::npos);
  EXPECT_NE(text(2, 9).find("let n = 5"), std::string::npos);
  EXPECT_NE(text(3, 13).find("an axis: one run for each value"), std::string::npos) << text(3, 13);
  EXPECT_NE(text(3, 24).find("detector"), std::string::npos);
  EXPECT_NE(text(4, 13).find("full extent"), std::string::npos);
  EXPECT_NE(text(1, 10).find("2 runs"), std::string::npos) << text(1, 10);
  EXPECT_EQ(text(1, 13), "");
}

TEST(Server, FindsDefinitions) {
  Client client;
  client.files["/t/base.cdb"] = "let m = 3\nbenchmark base { objects pebbles { size m } }\n";
  client.Open(kUri,
              "use \"base\"\nlet n = 5\nbenchmark b from base {\n  let k = n\n  cycles k * m\n"
              "  pebbles.size k\n  skip when pebbles.quantity > n\n}\nbenchmark c from b { }\n");
  const auto place = [&](int line, int character) {
    const Json location = client.At("definition", kUri, line, character);
    if (location.is_null()) return std::string();
    const Json& start = location["range"]["start"];
    return location["uri"].get<std::string>() + ":" + start["line"].dump() + ":" +
           start["character"].dump();
  };
  EXPECT_EQ(place(3, 10), "file:///t/a.cdb:1:4");
  EXPECT_EQ(place(4, 9), "file:///t/a.cdb:3:6");
  EXPECT_EQ(place(4, 13), "file:///t/base.cdb:0:4");
  EXPECT_EQ(place(2, 18), "file:///t/base.cdb:1:10");
  EXPECT_EQ(place(8, 17), "file:///t/a.cdb:2:10");
  EXPECT_EQ(place(5, 4), "file:///t/base.cdb:1:25");
  EXPECT_EQ(place(6, 14), "file:///t/base.cdb:1:25");
  EXPECT_EQ(place(6, 31), "file:///t/a.cdb:1:4");
  EXPECT_EQ(place(4, 3), "");
}

/// The text after the edits of a rename.
std::string Renamed(Client& client, const std::string& text, int line, int character,
                    const std::string& name) {
  client.Open(kUri, text);
  const Json result = client.At("rename", kUri, line, character, {{"newName", name}});
  if (result.is_null())
    return "error: " + client.sent.back()["error"]["message"].get<std::string>();
  std::string edited = text;
  Json edits = result["changes"][kUri];
  std::reverse(edits.begin(), edits.end());
  for (const Json& edit : edits) {
    const text::Source source("", edited);
    const auto offset = [&](const char* end) {
      const Json& place = edit["range"][end];
      return editor::OffsetOf(source, {place["line"], place["character"]});
    };
    const std::uint32_t begin = offset("start");
    edited.replace(begin, offset("end") - begin, edit["newText"]);
  }
  return edited;
}

TEST(Server, RenamesALetWhereverItIsUsed) {
  Client client;
  const std::string text =
      "let n = sweep(5, 6)  # \xF0\x9F\x98\x80\nlet m = 2 * n\n"
      "benchmark a { cycles n; objects { size m; mass n + 1 }; skip when n > 5 and cycles == m }\n"
      "benchmark b { let n = 7; cycles n }\n";
  EXPECT_EQ(Renamed(client, text, 0, 4, "count_of"),
            "let count_of = sweep(5, 6)  # \xF0\x9F\x98\x80\nlet m = 2 * count_of\n"
            "benchmark a { cycles count_of; objects { size m; mass count_of + 1 }; skip when "
            "count_of > 5 and cycles == m }\n"
            "benchmark b { let n = 7; cycles n }\n");
  EXPECT_EQ(Renamed(client, text, 3, 32, "k"),
            text.substr(0, text.find("benchmark b")) + "benchmark b { let k = 7; cycles k }\n");
}

TEST(Server, RenamesWhatOverridesToo) {
  Client client;
  EXPECT_EQ(
      Renamed(client, "benchmark a { let n = 5; cycles n }\nbenchmark b from a { let n = 6 }\n", 1,
              25, "k"),
      "benchmark a { let k = 5; cycles k }\nbenchmark b from a { let k = 6 }\n");
}

TEST(Server, RefusesARenameThatChangesTheRuns) {
  Client client;
  const std::string text = "let n = 5\nlet m = 6\nbenchmark a { cycles n; warmup m }\n";
  EXPECT_EQ(Renamed(client, text, 0, 4, "m").find("error: "), 0u);
  EXPECT_EQ(Renamed(client, text, 0, 4, "3d").find("error: "), 0u);
  EXPECT_EQ(Renamed(client, text, 0, 4, "skip").find("error: "), 0u);
  EXPECT_EQ(Renamed(client, text, 2, 16, "k").find("error: "), 0u) << "cycles is no let";
}

TEST(Server, FormatsAndCountsRuns) {
  Client client;
  client.Open(kUri, "benchmark b{cycles   sweep(1,2)\nobjects.quantity sweep(20 .. 22)}\n");
  const Json edits = client.At("formatting", kUri, 0, 0);
  ASSERT_EQ(edits.size(), 1u);
  EXPECT_NE(edits[0]["newText"].get<std::string>().find("benchmark b {\n"), std::string::npos);
  const Json hints = client.At("inlayHint", kUri, 0, 0);
  ASSERT_EQ(hints.size(), 1u) << hints;
  EXPECT_EQ(hints[0]["label"], "6 runs");
  EXPECT_EQ(hints[0]["position"], (Json{{"line", 0}, {"character", 11}}));
  EXPECT_EQ(hints[0]["tooltip"], "2 cycles x 3 quantity");
  client.Open(kUri, "benchmark b {\n");
  EXPECT_TRUE(client.At("formatting", kUri, 0, 0).is_null());
  EXPECT_EQ(client.sent.back()["error"]["code"], -32803);
}

TEST(Server, AnswersMalformedMessagesByName) {
  Client client(false);
  const auto code = [&](const std::string& message) {
    client.sent.clear();
    client.server().Handle(message);
    return client.sent.empty() ? 0 : client.sent[0].value("/error/code"_json_pointer, 0);
  };
  EXPECT_EQ(code(R"({"id":1,"method":"textDocument/hover"})"), -32002);
  client.Ask("initialize", nullptr);
  EXPECT_EQ(code("{"), -32700);
  EXPECT_EQ(code("\xFF\xFE"), -32700);
  EXPECT_EQ(code("[]"), -32600);
  EXPECT_EQ(code("{\"id\":1}"), -32600);
  EXPECT_EQ(code(R"({"id":[[1]],"method":"x"})"), -32600);
  EXPECT_EQ(code(R"({"id":1,"method":"frobnicate"})"), -32601);
  EXPECT_EQ(code(R"({"id":1,"method":"textDocument/hover","params":7})"), -32602);
  EXPECT_EQ(code(R"({"method":"textDocument/didOpen","params":[1,2]})"), 0);
  EXPECT_EQ(code(R"({"method":"$/cancelRequest","params":{"id":1}})"), 0);
  EXPECT_EQ(code(R"({"id":9,"result":null})"), 0);
  EXPECT_EQ(code(std::string(100'000, '[')), -32700);
  client.Open(kUri, "benchmark b { }\n");
  const Json far = {{"line", 1'000'000'000'000}, {"character", -3}};
  client.Tell(
      "textDocument/didChange",
      {{"textDocument", {{"uri", kUri}, {"version", 1}}},
       {"contentChanges",
        {{{"range", {{"start", far}, {"end", {{"line", "x"}}}}}, {"text", 5}}, 7, nullptr}}});
  EXPECT_EQ(code(R"({"id":1,"method":"shutdown"})"), 0);
  EXPECT_EQ(code(R"({"id":2,"method":"textDocument/hover"})"), -32600);
  client.Tell("exit", nullptr);
  EXPECT_TRUE(client.server().has_ended());
  EXPECT_TRUE(client.server().ended_well());
}

}  // namespace
}  // namespace cdb::tests
