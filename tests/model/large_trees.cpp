#include "axode/model/building/builder.hpp"
#include "tests/model/large_mechanisms.hpp"
#include "tests/support/counted_work.hpp"

namespace axode::test {
namespace {

class LargeTrees : public testing::TestWithParam<large::Mechanism> {};
INSTANTIATE_TEST_SUITE_P(Sound, LargeTrees, testing::ValuesIn(large::mechanisms), large::name_of);
INSTANTIATE_TEST_SUITE_P(Faulty, LargeTrees, testing::ValuesIn(large::faulty_mechanisms), large::name_of);

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
