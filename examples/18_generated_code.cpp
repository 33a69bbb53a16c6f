// The dynamics of one arm as C without dependencies, which a controller can compile and call without axode.
#include <cstdio>
#include <vector>

#include "axode/codegen.hpp"
#include "axode/io.hpp"

using namespace axode;

int main() {
  const Model arm = load(AXODE_ROBOTS_DIR "/arm7.toml");
  const std::vector<codegen::Function> functions{
      {"inverse_dynamics"},
      {"forward_dynamics"},
      {"jacobian", arm.frame_index("flange"), Representation::hybrid}};
  const codegen::Source source = codegen::c_source(arm, functions, {.prefix = "arm"});

  std::printf("%zu bytes of C\n", source.text.size());  // std::ofstream("arm.c") << source.text;
  for (const auto& [name, count] : source.functions)
    std::printf("%s: %ld products, %ld sums, %ld divisions, %ld sines and cosines\n", name.c_str(),
                count.products, count.sums, count.divisions, count.angles);
}
