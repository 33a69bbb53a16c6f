#pragma once
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "axode/batch.hpp"

namespace axode::codegen {

/// Compiled C that is loaded into this process as long as a MachineCode refers to it.
class MachineCode {
 public:
  /// Compiles a source with these flags, or takes it from the cache. The key of the cache is made of the
  /// source, the compiler's name and version, the flags and the processor. Throws std::runtime_error if there
  /// is no compiler or it fails, and CompilationEnded if the monitor, which is called while the compiler
  /// runs, returns false.
  MachineCode(const std::string& source, const std::vector<std::string>& flags,
              const batch::Monitor& monitor);

  /// The address of a symbol. Throws std::runtime_error if there is none of that name.
  void* address(const std::string& name) const;

  /// The path of the shared library, for other programs that load it. If there is no cache, the file is
  /// removed with the last MachineCode that refers to it.
  const std::filesystem::path& file() const { return file_; }

 private:
  std::filesystem::path file_;
  std::shared_ptr<void> folder_;  ///< the folder of the library if there is no cache
  std::shared_ptr<void> library_;
};

}  // namespace axode::codegen
