#pragma once
#include <gtest/gtest.h>

#include <algorithm>

#include "axode/io.hpp"
#include "tests/support/json_numbers.hpp"
#include "tests/support/shared_files.hpp"

/// Files of single machines among the vectors, each of a kind.
namespace axode::test {

inline std::filesystem::path machines_folder() { return vectors_folder() / "machines"; }

/// The parameter of a test that is skipped because there are no files of its kind.
inline constexpr const char* no_files = "NoFiles";

/// Names of the machines of one of several kinds, for tests with a parameter.
inline std::vector<std::string> machines_of(std::initializer_list<std::string> kinds) {
  std::vector<std::string> names;
  for (const auto& file : files_ending_in(machines_folder(), ".json"))
    if (std::ranges::find(kinds, read_json(file).at("kind").text()) != kinds.end())
      names.push_back(file.stem().string());
  return names.empty() ? std::vector<std::string>{no_files} : names;
}

/// A test of the machine of a file.
class MachineOfFile : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == no_files) GTEST_SKIP() << missing(machines_folder(), "AXODE_VECTORS");
    file_ = read_json(machines_folder() / (GetParam() + ".json"));
  }
  Description drawing() const { return read_drawing_text(file_.at("model").text(), GetParam()); }

  Json file_;
};

}  // namespace axode::test
