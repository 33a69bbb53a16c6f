#include "axode/model/building/builder.hpp"
#include "tests/model/large_mechanisms.hpp"
#include "tests/support/counted_work.hpp"

namespace axode::test {
namespace {

class LargeTrees : public testing::TestWithParam<LargeMechanism> {};
INSTANTIATE_TEST_SUITE_P(Sound, LargeTrees, testing::ValuesIn(large_mechanisms), name_of_mechanism);
INSTANTIATE_TEST_SUITE_P(Faulty, LargeTrees, testing::ValuesIn(faulty_large_mechanisms), name_of_mechanism);

TEST_P(LargeTrees, AreBuiltByWorkInProportionToTheirSize) {
  expect_work_in_proportion_to_size([](int n) {
    try {
      ModelBuilder(GetParam().make(n)).build();
    } catch (const ModelError&) {
    }
  });
}

}  // namespace
}  // namespace axode::test
