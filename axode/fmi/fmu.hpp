#pragma once
#include <string>
#include <vector>

#include "axode/fmi/instance.hpp"
#include "axode/fmi/model_description.hpp"

/// Export of mechanisms as FMUs (Functional Mock-up Units) for FMI 2.0 and 3.0. The binary of an FMU contains
/// this library and reads the drawing of the mechanism, a TOML file, from the resources of the FMU.
namespace axode::fmi {

/// The options of the export of an FMU.
struct ExportOptions {
  Version version = Version::fmi3;
  std::vector<Kind> kinds = {Kind::model_exchange, Kind::co_simulation};
  Settings settings = {};
};

/// A file in an FMU; an FMU is a zip archive.
struct FmuFile {
  std::string name, contents;
};

/// Makes the files of an FMU of a mechanism. Of its shapes only those that can touch others are included.
/// `binary` is the contents of the shared object axode_fmu.so, which is the same for all mechanisms. Throws
/// std::invalid_argument if the mechanism has something that FMUs of one of options.kinds do not support (see
/// check_supported()), if a frame does not exist, and if options.kinds is empty.
std::vector<FmuFile> fmu_files(const Model& model, const ExportOptions& options, std::string binary);

}  // namespace axode::fmi
