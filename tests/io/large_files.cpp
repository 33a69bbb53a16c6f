#include <gtest/gtest.h>

#include "axode/io.hpp"
#include "axode/model/building/builder.hpp"
#include "tests/io/same_mechanism.hpp"
#include "tests/model/large_mechanisms.hpp"
#include "tests/support/counted_work.hpp"

namespace axode::test {
namespace {

class LargeFiles : public testing::TestWithParam<large::Mechanism> {};
INSTANTIATE_TEST_SUITE_P(, LargeFiles, testing::ValuesIn(large::mechanisms), large::name_of);

TEST_P(LargeFiles, AreWrittenAndReadByWorkInProportionToTheirSize) {
  expect_work_in_proportion_to_size([](int n) {
    const Model model = ModelBuilder(GetParam().make(n)).build();
    const Model drawn = ModelBuilder(read_drawing_text(drawing_of(model), "large.toml")).build();
    EXPECT_EQ(drawn.n_frames(), model.n_frames());
    const Model in_urdf = ModelBuilder(read_urdf_text(urdf_of(model), "large.urdf")).build();
    EXPECT_EQ(in_urdf.nv(), model.nv());
    std::ostringstream mjcf;
    write_mjcf(model, mjcf);
  });
}

}  // namespace
}  // namespace axode::test
