#include <cstddef>
#include <cstdint>
#include <sstream>

#include "axode/io.hpp"
#include "axode/io/reading.hpp"
#include "axode/model/builder.hpp"

/// Whatever the bytes: faults or a model, and a model can be written. Nothing else may be thrown.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const axode::io::Reading reading = axode::io::read_sdf(text, "fuzz.sdf", axode::Strictness::lenient);
  const axode::ModelBuilder builder(reading.description);
  const bool sound = !axode::io::has_error(reading.faults);
  if (axode::io::has_error(builder.check()) || !sound) return 0;
  std::ostringstream out;
  write_drawing(builder.build(), out);
  return 0;
}
