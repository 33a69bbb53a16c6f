#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <iostream>

/// Lists the cases by their plain names. GoogleTest's own list adds remarks to the names of typed and
/// parametrised tests; ctest cannot read these and would show them as part of the name.
static void list_cases() {
  const testing::UnitTest& all = *testing::UnitTest::GetInstance();
  for (int i = 0; i < all.total_test_suite_count(); ++i) {
    const testing::TestSuite& suite = *all.GetTestSuite(i);
    std::cout << suite.name() << ".\n";
    for (int j = 0; j < suite.total_test_count(); ++j)
      std::cout << "  " << suite.GetTestInfo(j)->name() << '\n';
  }
}

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  if (GTEST_FLAG_GET(list_tests)) {
    list_cases();
    return 0;
  }
  return RUN_ALL_TESTS();
}
