#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "axode/io.hpp"
#include "tests/io/same_mechanism.hpp"
#include "tests/support/shared_files.hpp"

namespace axode {
namespace {

using ::testing::HasSubstr;

/// A row of tests/data/bad/expected.tsv: a fault that the reader must report for a file.
struct Expectation {
  std::string file, rule, message;
  int line = 0;
};

void PrintTo(const Expectation& e, std::ostream* out) { *out << e.file << ":" << e.line << " " << e.rule; }

std::filesystem::path bad_folder() { return std::filesystem::path(AXODE_SOURCE_DIR) / "tests/data/bad"; }

std::vector<Expectation> expectations() {
  std::ifstream table(bad_folder() / "expected.tsv");
  std::vector<Expectation> rows;
  std::string text;
  std::getline(table, text);  // skips the heading
  while (std::getline(table, text)) {
    std::istringstream row(text);
    Expectation e;
    std::string line;
    std::getline(row, e.file, '\t'), std::getline(row, e.rule, '\t'), std::getline(row, line, '\t');
    std::getline(row, e.message);
    e.line = std::stoi(line);
    rows.push_back(e);
  }
  return rows;
}

std::string all(const std::vector<Fault>& faults) {
  std::string text;
  for (const Fault& fault : faults)
    text += to_string(fault) + " [" + std::string(to_string(fault.rule)) + "]\n";
  return text;
}

bool meets(const Fault& fault, const Expectation& e) {
  return fault.severity == Severity::error && to_string(fault.rule) == e.rule &&
         fault.source.line == e.line && fault.message.find(e.message) != std::string::npos;
}

class BadFile : public ::testing::TestWithParam<Expectation> {};

TEST_P(BadFile, IsRefusedWithRuleLineAndReason) {
  const Expectation& e = GetParam();
  const std::filesystem::path file = bad_folder() / e.file;
  const std::vector<Fault> faults = check(file, Base::as_described, Strictness::strict);
  EXPECT_TRUE(std::any_of(faults.begin(), faults.end(), [&](const Fault& f) { return meets(f, e); }))
      << "expected " << e.rule << " in line " << e.line << ": " << e.message << "; found\n"
      << all(faults);
  for (const Fault& fault : faults) EXPECT_EQ(fault.source.file, file.string());
  try {
    load(file, Base::as_described, Strictness::strict);
    ADD_FAILURE() << "load() accepts what check() refuses";
  } catch (const ModelError& error) {
    EXPECT_THAT(error.what(), HasSubstr(e.message));
  }
}

std::string test_name(const ::testing::TestParamInfo<Expectation>& info) {
  std::string name = info.param.file + "_" + std::to_string(info.index);
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  return name;
}
INSTANTIATE_TEST_SUITE_P(Io, BadFile, ::testing::ValuesIn(expectations()), test_name);

TEST(BadFiles, EachHasARowInTheTable) {
  const std::vector<Expectation> rows = expectations();
  for (const auto& entry : std::filesystem::directory_iterator(bad_folder())) {
    const std::string name = entry.path().filename().string();
    const bool listed =
        std::any_of(rows.begin(), rows.end(), [&](const Expectation& e) { return e.file == name; });
    EXPECT_TRUE(listed || name == "expected.tsv") << name;
  }
}

// Faults that other programs accept, or with which one can compute although no real body is like that.
TEST(BadFiles, ThoseThatAreOnlyDoubtfulAreLoadedWithTheSameFaultsAsWarnings) {
  const std::set<std::string> doubtful{"limits_crossed.urdf",
                                       "limits_crossed.toml",
                                       "mimic_of_unknown_joint.urdf",
                                       "mass_zero.toml",
                                       "follows_unknown_joint.toml",
                                       "inertia_of_no_density.toml",
                                       "inertia_negative.toml",
                                       "second_axis_that_is_equal.urdf",
                                       "mesh_scale_of_four_numbers.urdf",
                                       "mass_and_inertia_zero.urdf",
                                       "without_a_version.sdf",
                                       "version_in_words.sdf",
                                       "limits_crossed.sdf",
                                       "mimic_of_unknown_joint.sdf",
                                       "shape_without_size.sdf",
                                       "rpy_in_degrees.toml",
                                       "rpy_in_degrees.urdf",
                                       "pose_in_degrees.sdf",
                                       "collision_sphere_of_radius_0.toml"};
  for (const auto& entry : std::filesystem::directory_iterator(bad_folder())) {
    const std::string name = entry.path().filename().string();
    if (name == "expected.tsv") continue;
    if (!doubtful.contains(name)) {
      EXPECT_THROW(load(entry.path()), ModelError) << name;
      continue;
    }
    const std::vector<Fault> strict = check(entry.path(), Base::as_described, Strictness::strict);
    const Model model = load(entry.path());
    ASSERT_GE(model.warnings().size(), strict.size()) << name;
    EXPECT_EQ(model.warnings().size(), check(entry.path()).size());
    for (const Fault& fault : strict)
      EXPECT_TRUE(std::any_of(model.warnings().begin(), model.warnings().end(), [&](const Fault& warning) {
        return warning.severity == Severity::warning && warning.rule == fault.rule &&
               warning.element == fault.element && warning.source.line == fault.source.line;
      })) << to_string(fault);
    EXPECT_EQ(test::disparity(model, ModelBuilder(read_drawing_text(test::drawing_of(model), name)).build()),
              0);
  }
}

TEST(BadFiles, WhatCannotBeReadIsAFault) {
  const std::filesystem::path breaks_off = "/proc/self/mem";
  for (const std::filesystem::path& path : {bad_folder() / "no_such_file.urdf", bad_folder(), breaks_off}) {
    const std::vector<Fault> faults = check(path);
    ASSERT_EQ(faults.size(), 1U);
    EXPECT_EQ(faults[0].rule, Rule::unreadable_file);
    EXPECT_EQ(faults[0].source.file, path.string());
    EXPECT_THROW(load(path), ModelError);
  }
}

}  // namespace
}  // namespace axode
