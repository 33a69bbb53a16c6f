#include "reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return axode::test::fuzz(axode::io::read_urdf, data, size);
}
