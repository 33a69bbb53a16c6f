#pragma once
#include <dlfcn.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/run_program.hpp"

namespace axode::test {

/// C source that is compiled by the compiler of these tests into a shared library, which is then loaded.
class Compiled {
 public:
  explicit Compiled(const std::string& source,
                    const std::vector<std::string>& language = {"-x", "c", "-std=c99"}) {
    const std::string file = folder_.write("generated.c", source), library = folder_.file("generated.so");
    std::vector<std::string> words{AXODE_COMPILER, "-O0", "-fPIC", "-shared"};
    words.insert(words.end(), language.begin(), language.end());
    words.insert(words.end(), {file, "-o", library});
    const Outcome outcome = run(words);
    if (outcome.code != 0) throw std::runtime_error("the generated file does not compile: " + outcome.err);
    handle_ = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle_ == nullptr) throw std::runtime_error(dlerror());
  }
  ~Compiled() { dlclose(handle_); }
  Compiled(const Compiled&) = delete;
  Compiled& operator=(const Compiled&) = delete;

  template <class Signature> Signature* function(const std::string& name) const {
    void* address = dlsym(handle_, name.c_str());
    if (address == nullptr) throw std::runtime_error("the generated file has no function " + name);
    return reinterpret_cast<Signature*>(address);
  }

 private:
  TemporaryFolder folder_;
  void* handle_ = nullptr;
};

}  // namespace axode::test
