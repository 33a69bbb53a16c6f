#include "tests/support/smallest_failure.hpp"

#include <gtest/gtest-spi.h>

#include <sstream>

#include "axode/io.hpp"
#include "tests/support/random_tree.hpp"

namespace axode::test {
namespace {

/// The first failure that a run of the law reports; empty if there is none.
std::string failure_of(const std::function<void()>& law) {
  testing::TestPartResultArray results;
  try {
    const testing::ScopedFakeTestPartResultReporter reporter(
        testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &results);
    law();
  } catch (const std::exception& error) {
    return std::string("throws: ") + error.what();
  }
  for (int k = 0; k < results.size(); ++k)
    if (results.GetTestPartResult(k).failed()) return results.GetTestPartResult(k).message();
  return {};
}

}  // namespace

std::string smallest_failure(const std::function<void()>& law) {
  const int most = last_mechanism().bodies;
  for (int bodies = 1; bodies < most; ++bodies) {
    const AtMostBodies limit(bodies);
    const std::string failure = failure_of(law);
    if (failure.empty()) continue;
    std::ostringstream text;
    text << "with " << bodies << (bodies == 1 ? " body" : " bodies") << " it still fails:\n" << failure;
    text << "\nThe mechanism as a drawing:\n";
    write_drawing(ModelBuilder(*last_mechanism().description).build(), text);
    return text.str();
  }
  return "with fewer bodies it does not fail";
}

}  // namespace axode::test
