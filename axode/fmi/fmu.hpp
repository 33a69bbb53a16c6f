#pragma once
#include <string>
#include <vector>

#include "axode/fmi/instance.hpp"
#include "axode/fmi/model_description.hpp"

/// Mechanisms as FMUs (Functional Mock-up Units) for FMI 2.0 and 3.0. The binary of an FMU contains the
/// library and reads the mechanism as a drawing from the resources of the FMU, so that an FMU simulates what
/// the library does.
namespace axode::fmi {

/// The choices of an export.
struct ExportOptions {
  Version version = Version::fmi3;
  std::vector<Kind> kinds = {Kind::model_exchange, Kind::co_simulation};
  Settings settings = {};
};

/// A file inside an FMU, which is a zip archive.
struct FmuFile {
  std::string name, contents;
};

/// The files of an FMU of a mechanism. `binary` is the contents of the shared object axode_fmu.so, which is
/// the same for all mechanisms. Shapes are left out. Throws std::invalid_argument, in one sentence, for what
/// an FMU of a kind does not have (see check_supported()), for unknown frames and if no kind is given.
std::vector<FmuFile> fmu_files(const Model& model, const ExportOptions& options, std::string binary);

}  // namespace axode::fmi
