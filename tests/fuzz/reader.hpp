#pragma once
#include <cstddef>
#include <cstdint>
#include <sstream>

#include "axode/io.hpp"
#include "axode/io/reading.hpp"
#include "axode/model/building/builder.hpp"

namespace axode::test {

/// For every sequence of bytes, a reader of files returns faults or a model, and every such model can be
/// written. No other exception may be thrown.
inline int fuzz(io::Reading (*read)(std::string_view, const std::string&, Strictness),
                const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const io::Reading reading = read(text, "fuzz", Strictness::lenient);
  const ModelBuilder builder(reading.description);
  if (io::has_error(builder.check()) || io::has_error(reading.faults)) return 0;
  std::ostringstream out;
  write_drawing(builder.build(), out);
  return 0;
}

}  // namespace axode::test
