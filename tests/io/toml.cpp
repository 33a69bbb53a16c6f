#include "axode/io/drawing/toml.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace axode::io::toml {
namespace {

/// The value of the key x, or null if there is none.
const Value* x_of(const Document& document) {
  if (document.failure) return nullptr;
  const auto found = document.root().table()->find("x");
  return found == document.root().table()->end() ? nullptr : found->second.value;
}

TEST(Toml, Numbers) {
  const std::vector<std::pair<std::string, double>> numbers{
      {"0", 0},
      {"+99", 99},
      {"-17", -17},
      {"1_000", 1000},
      {"0xDEAD_beef", 0xDEADBEEF},
      {"0o755", 0755},
      {"0b1101", 13},
      {"1.0", 1},
      {"-0.01", -0.01},
      {"5e+22", 5e22},
      {"1e06", 1e6},
      {"-2E-2", -2e-2},
      {"6.626e-34", 6.626e-34},
      {"9_0.1_2", 90.12},
      {"0.1", 0.1},
      {"0e0", 0},
      {"inf", INFINITY},
      {"-inf", -INFINITY},
      {"4.9406564584124654e-324", 4.9406564584124654e-324},
      {"1.7976931348623157e308", 1.7976931348623157e308}};
  for (const auto& [text, number] : numbers) {
    const Document document = parse("x = " + text);
    const Value* x = x_of(document);
    ASSERT_TRUE(x != nullptr && x->number() != nullptr) << text;
    EXPECT_EQ(*x->number(), number) << text;
  }
  for (const char* text : {"nan", "+nan", "-nan"}) {
    const Document document = parse(std::string("x = ") + text);
    EXPECT_TRUE(std::isnan(*x_of(document)->number()));
  }
}

TEST(Toml, WhatIsNoNumberIsAFailure) {
  for (const char* text : {"",      "01",
                           "+01",   "1_",
                           "_1",    "1__0",
                           "1.",    ".5",
                           "1.e5",  "1e",
                           "1e5.0", "--1",
                           "+-1",   "0x",
                           "0xg",   "+0x1",
                           "0b2",   "0o8",
                           "1_.0",  "1._0",
                           "Inf",   "NaN",
                           "True",  "1a",
                           "1 2",   "e5",
                           "1e_5",  "0x_1",
                           "+",     "-",
                           "1e999", "1,5",
                           "yes",   "0x10000000000000000"})
    EXPECT_TRUE(parse(std::string("x = ") + text).failure) << text;
}

TEST(Toml, Texts) {
  const std::vector<std::pair<std::string, std::string>> texts{
      {R"("a \"b\" \\ \t\n\b\f\r")", "a \"b\" \\ \t\n\b\f\r"},
      {R"("\u00E9 \u20ac \U0001F980 é")", "é € 🦀 é"},
      {R"('C:\a "b"')", "C:\\a \"b\""},
      {"\"\"", ""},
      {"''", ""},
      {"\"\"\"\na\nb\"\"\"", "a\nb"},
      {"\"\"\"\r\na\r\nb\"\"\"", "a\nb"},
      {"\"\"\"a \\\n   \n  b\"\"\"", "a b"},
      {"\"\"\"a\\  \r\n b\"\"\"", "ab"},
      {R"("""a""b"""")", "a\"\"b\""},
      {R"(""""a""""")", "\"a\"\""},
      {"'''\na\\\n'b'''''", "a\\\n'b''"},
      {"''''''", ""}};
  for (const auto& [toml, text] : texts) {
    const Document document = parse("x = " + toml + " # comment");
    const Value* x = x_of(document);
    ASSERT_TRUE(x != nullptr && x->text() != nullptr) << toml;
    EXPECT_EQ(*x->text(), text) << toml;
  }
}

TEST(Toml, WhatIsNoTextIsAFailure) {
  for (const char* toml : {"\"a", "'a", "\"a\n\"", "'a\n'", "\"\\x41\"", "\"\\u12\"", "\"\\ud800\"",
                           "\"\\U00110000\"", "\"a\x01\"", "'a\x7f'", "\"\"\"a", "'''a''", "\"a\\\n b\"",
                           "\"\\\"", "\"a\"b", "\"\"\"\\a\"\"\"", "\"\"\"a\"\"\"\"\"\"", "\"\"\"a\rb\"\"\""})
    EXPECT_TRUE(parse(std::string("x = ") + toml + "\n").failure) << toml;
}

TEST(Toml, DatesAndTruthValues) {
  for (const char* toml : {"1979-05-27", "1979-05-27T07:32:00Z", "1979-05-27 07:32:00.5-07:00", "07:32:00"}) {
    const Document document = parse(std::string("x = ") + toml);
    const Value* x = x_of(document);
    ASSERT_NE(x, nullptr) << toml;
    EXPECT_TRUE(std::holds_alternative<Date>(x->content)) << toml;
  }
  EXPECT_TRUE(*x_of(parse("x = true"))->flag());
}

TEST(Toml, ArraysTablesAndKeys) {
  const Document document = parse(R"(
a.b . "c.d" = 1
a.'e' = [ 1, [ 2 ], # comment
  { f = 3 }, ]
[x.y]  # header
1-2_3 = {}
"" = { g.h = 1, g.i = 2 }
[x]
j = 0
[[x.k]]
l = 1
[x.k.m]
[[x.k]]
[a.n])");
  ASSERT_FALSE(document.failure) << document.failure->message;
  const auto in = [](const Value& value, const std::string& key) -> const Value& {
    return *value.table()->at(key).value;
  };
  const Value& root = document.root();
  EXPECT_EQ(*in(in(in(root, "a"), "b"), "c.d").number(), 1);
  const Array& e = *in(in(root, "a"), "e").array();
  ASSERT_EQ(e.size(), 3U);
  EXPECT_EQ(*(*e[1]->array())[0]->number(), 2);
  EXPECT_EQ(*in(*e[2], "f").number(), 3);
  EXPECT_EQ(in(in(root, "x"), "y").table()->size(), 2U);
  EXPECT_EQ(*in(in(in(in(root, "x"), "y"), ""), "g").table()->at("i").value->number(), 2);
  const Array& k = *in(in(root, "x"), "k").array();
  ASSERT_EQ(k.size(), 2U);
  EXPECT_EQ(k[0]->table()->size(), 2U);
  EXPECT_EQ(k[0]->line, 10);
  EXPECT_EQ(k[1]->table()->size(), 0U);
  EXPECT_EQ(in(root, "x").table()->at("j").line, 9);
}

TEST(Toml, NothingIsGivenTwice) {
  for (const char* toml : {"a = 1\na = 2",
                           "a = 1\n\"a\" = 2",
                           "a = 1\na.b = 2",
                           "a.b = 1\na.b.c = 2",
                           "a = {}\na.b = 1",
                           "a = {}\n[a]",
                           "a = {}\n[a.b]",
                           "[a]\n[a]",
                           "a.b = 1\n[a]",
                           "[t]\na.b = 1\n[t.a]",
                           "a = []\n[[a]]",
                           "[a]\n[[a]]",
                           "[[a]]\n[a]",
                           "a = [{}]\n[a.b]",
                           "[a.b.c]\n[a]\nb.c.d = 1",
                           "[a.b]\n[a]\nb.d = 1",
                           "a = { b = 1, b = 2 }",
                           "a = { b.c = 1 }\na.b.d = 2",
                           "a = { b = {}, b.c = 1 }",
                           "[[a.b]]\n[a]\nb.c = 1"})
    EXPECT_TRUE(parse(toml).failure) << toml;
  for (const char* toml :
       {"[a.b]\n[a]", "[a.b]\n[a]\nc = 1\n[a.d]", "a.b = 1\na.c = 2", "a.b.c = 1\n[a.b.d]\n[a.e]",
        "[[a]]\n[a.b]\n[[a]]\n[a.b]", "[[a]]\nb.c = 1\n[[a]]\nb.c = 1"})
    EXPECT_FALSE(parse(toml).failure) << toml;
}

TEST(Toml, WhatIsNoDocumentIsAFailureWithItsLine) {
  for (const char* toml : {"a",
                           "a =",
                           "= 1",
                           "a = 1 b = 2",
                           "[a",
                           "[a] b = 1",
                           "[]",
                           "[[a]",
                           "[ [a]]",
                           "[[a] ]",
                           "[a.]",
                           "[.a]",
                           "a..b = 1",
                           "a. = 1",
                           "a = [1",
                           "a = [1 2]",
                           "a = [,]",
                           "a = {b = 1",
                           "a = {,}",
                           "a = {b = 1,}",
                           "a = {\nb = 1}",
                           "a = {b}",
                           "\"\"\"a\"\"\" = 1",
                           "é = 1",
                           "a = é",
                           "a\x01 = 1",
                           "# \x01",
                           "a = 1 \r b = 2",
                           "]",
                           "a = [1]]"}) {
    const Document document = parse(std::string("# first line\n") + toml);
    ASSERT_TRUE(document.failure) << toml;
    EXPECT_GE(document.failure->line, 2) << toml;
  }
}

TEST(Toml, DepthCostsNoStack) {
  std::string dots = "a", brackets;
  for (int k = 0; k < 200000; ++k) dots += ".a", brackets += '[';
  EXPECT_FALSE(parse(dots + " = 1\n").failure);
  EXPECT_FALSE(parse("[" + dots + "]\n").failure);
  EXPECT_TRUE(parse("a = " + brackets).failure);
}

}  // namespace
}  // namespace axode::io::toml
