#include <cstdio>
#include <exception>

#include "apps/demo/demo.hpp"

/// The command `axode demo` as a program of its own, which `make demo` builds.
int main() {
  try {
    axode::command::show_demo();
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "axode_demo: %s\n", error.what());
    return 1;
  }
}
