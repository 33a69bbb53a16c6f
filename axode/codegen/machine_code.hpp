#pragma once
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "axode/batch.hpp"

namespace axode::codegen {

/// Compiled C in this process, as long as somebody has it.
class MachineCode {
 public:
  /// Compiled with these flags by find_compiler(), or taken from the cache, where it is kept under its
  /// source, the compiler's name and version, the flags and the processor. Throws std::runtime_error where
  /// there is no compiler or it fails, and CompilationEnded where the monitor, told while it runs, says so.
  MachineCode(const std::string& source, const std::vector<std::string>& flags,
              const batch::Monitor& monitor);

  /// Throws std::runtime_error where there is none of that name.
  void* address(const std::string& name) const;

  /// The shared library, for others who load it. Where there is no cache it is removed with the last
  /// MachineCode.
  const std::filesystem::path& file() const { return file_; }

 private:
  std::filesystem::path file_;
  std::shared_ptr<void> folder_;  ///< that has the library, where there is no cache
  std::shared_ptr<void> library_;
};

}  // namespace axode::codegen
