#include "apps/shell/version.hpp"

#include <fmt/format.h>
#include <zip.h>

#include <CLI/Version.hpp>
#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "axode/scalar/instruction_set.hpp"

namespace axode::command {

std::string version() {
  return fmt::format(
      "axode {}\n"
      "revision      {}\n"
      "compiler      {}, {}\n"
      "instructions  {}\n"
      "libraries     Eigen {}.{}.{}, tinyxml2 {}, CLI11 {}, fmt {}.{}.{}, JSON for Modern C++ {}.{}.{}, "
      "libzip {}",
      AXODE_VERSION, AXODE_REVISION, AXODE_COMPILER, AXODE_BUILD_TYPE, instruction_set(), EIGEN_WORLD_VERSION,
      EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION, AXODE_TINYXML2_VERSION, CLI11_VERSION, FMT_VERSION / 10000,
      FMT_VERSION / 100 % 100, FMT_VERSION % 100, NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
      NLOHMANN_JSON_VERSION_PATCH, zip_libzip_version());
}

const char* build_date() { return AXODE_DATE; }

}  // namespace axode::command
