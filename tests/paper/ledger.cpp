#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/shared_files.hpp"

/// The ledger of the paper's equations, equations.tsv: a table with the columns test, id, section, meaning,
/// status, stage and code, one row for each equation. Every row of a stage that is reached has a test
/// Paper.<test>. The column code names a header and a function in it; tools/ledger_coverage.py checks that
/// the test runs that function. The site's page about the paper is generated from this table.
namespace axode::test::paper {
namespace {

const std::set<std::string> stages_reached{"foundation", "kinematics", "dynamics", "derivatives"};

struct Row {
  std::string test, status, stage, code;
};

std::filesystem::path source_folder() { return AXODE_SOURCE_DIR; }
std::filesystem::path ledger_file() { return source_folder() / "tests/paper/equations.tsv"; }

std::vector<std::string> lines_of(const std::filesystem::path& file) {
  std::vector<std::string> lines;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::vector<Row> read_ledger() {
  std::vector<Row> rows;
  for (const std::string& line : lines_of(ledger_file())) {
    std::vector<std::string> columns;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, '\t');) columns.push_back(cell);
    if (columns.size() != 7) throw std::runtime_error("a row of the ledger has not 7 columns: " + line);
    rows.push_back({columns[0], columns[4], columns[5], columns[6]});
  }
  rows.erase(rows.begin());  // the first row has the names of the columns
  return rows;
}

std::set<std::string> tests_of_the_paper() {
  std::set<std::string> names;
  const testing::UnitTest& all = *testing::UnitTest::GetInstance();
  for (int s = 0; s < all.total_test_suite_count(); ++s) {
    const testing::TestSuite& suite = *all.GetTestSuite(s);
    if (suite.name() == std::string("Paper"))
      for (int t = 0; t < suite.total_test_count(); ++t) names.insert(suite.GetTestInfo(t)->name());
  }
  return names;
}

/// The text of every test of the suite, from its TEST line to the next one.
std::map<std::string, std::string> texts_of_the_tests() {
  std::map<std::string, std::string> texts;
  const std::string start = "TEST(Paper, ";
  for (const auto& entry : std::filesystem::directory_iterator(source_folder() / "tests" / "paper")) {
    if (entry.path().extension() != ".cpp") continue;
    std::ifstream stream(entry.path());
    std::string name;
    for (std::string line; std::getline(stream, line);) {
      if (line.starts_with(start)) name = line.substr(start.size(), line.find(')') - start.size());
      if (!name.empty()) texts[name] += line + '\n';
      if (line == "}") name.clear();
    }
  }
  return texts;
}

class Ledger : public testing::Test {
 protected:
  void SetUp() override {
    rows = read_ledger();
    ASSERT_FALSE(rows.empty());
  }
  std::vector<Row> rows;
};

TEST_F(Ledger, EveryRowOfAStageReachedHasATest) {
  const std::set<std::string> tests = tests_of_the_paper();
  for (const Row& row : rows)
    EXPECT_TRUE(!stages_reached.contains(row.stage) || tests.contains(row.test))
        << "no test Paper." << row.test;
}

TEST_F(Ledger, IsThatOfThePaperAndAColumnMore) {
  const std::filesystem::path original = shared_folder("AXODE_LEDGER", "shared/paper/equations.tsv");
  if (!std::filesystem::is_regular_file(original))
    GTEST_SKIP() << "no ledger at " << original.lexically_normal() << "; AXODE_LEDGER names another";
  std::vector<std::string> lines = lines_of(ledger_file());
  for (std::string& line : lines) line.erase(line.rfind('\t'));
  EXPECT_EQ(lines, lines_of(original));
}

TEST_F(Ledger, EveryRowNamesCodeThatIsThere) {
  for (const Row& row : rows) {
    const std::size_t colon = row.code.find(':');
    ASSERT_NE(colon, std::string::npos) << row.code;
    const std::vector<std::string> lines = lines_of(source_folder() / "axode" / row.code.substr(0, colon));
    EXPECT_TRUE(std::ranges::any_of(lines,
                                    [&](const std::string& line) {
                                      const std::size_t start = line.find_first_not_of(' ');
                                      return line.find(row.code.substr(colon + 1)) != std::string::npos &&
                                             line.compare(start, 2, "//") != 0;
                                    }))
        << "Paper." << row.test << " names " << row.code;
  }
}

TEST_F(Ledger, EveryTestIsARow) {
  std::set<std::string> names;
  for (const Row& row : rows) EXPECT_TRUE(names.insert(row.test).second) << row.test << " appears twice";
  for (const std::string& test : tests_of_the_paper())
    EXPECT_TRUE(names.contains(test)) << "Paper." << test << " is in no row";
}

TEST_F(Ledger, ErrataAndOnlyErrataShowThatThePrintedFormFails) {
  const std::map<std::string, std::string> texts = texts_of_the_tests();
  for (const Row& row : rows) {
    const auto text = texts.find(row.test);
    if (text == texts.end()) continue;
    const bool shown = text->second.find("eq.fails(") != std::string::npos;
    EXPECT_EQ(shown, row.status == "erratum")
        << "Paper." << row.test << " is a row with status " << row.status;
    EXPECT_NE(text->second.find("eq.holds("), std::string::npos) << "Paper." << row.test << " shows nothing";
  }
}

}  // namespace
}  // namespace axode::test::paper
