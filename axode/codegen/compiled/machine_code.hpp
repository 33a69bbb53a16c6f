#pragma once
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "axode/batch.hpp"

namespace axode::codegen {

/// Compiled C, which stays loaded in this process as long as a MachineCode refers to it.
class MachineCode {
 public:
  /// Compiles a C source with the given flags to a shared library, or loads the library from a cache if it
  /// has been compiled before from the same source, with the same compiler and flags, for the same processor.
  /// The monitor, a callback, is called while the compiler runs or while another process compiles the same
  /// source. Throws std::runtime_error if there is no compiler or it fails, and CompilationEnded if the
  /// monitor returns false.
  MachineCode(const std::string& source, const std::vector<std::string>& flags,
              const batch::Monitor& monitor);

  /// The address of a symbol of the library. Throws std::runtime_error if there is no symbol of that name.
  void* address(const std::string& name) const;

  /// The path of the compiled shared library, which other programs can load. If the cache could not be used,
  /// the file is deleted with the last MachineCode that refers to it.
  const std::filesystem::path& file() const { return file_; }

 private:
  std::filesystem::path file_;
  std::shared_ptr<void> folder_;  ///< temporary folder of the library if the cache cannot be used
  std::shared_ptr<void> library_;
};

}  // namespace axode::codegen
