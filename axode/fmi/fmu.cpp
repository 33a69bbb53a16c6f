#include "axode/fmi/fmu.hpp"

#include <sstream>
#include <stdexcept>

#include "axode/fmi/resources.hpp"
#include "axode/fmi/sources.hpp"
#include "axode/io.hpp"
#include "axode/model/building/builder.hpp"

namespace axode::fmi {
namespace {

#if defined(__aarch64__)
constexpr const char *platform_2 = "aarch64-linux", *platform_3 = "aarch64-linux";
#else
constexpr const char *platform_2 = "linux64", *platform_3 = "x86_64-linux";
#endif

/// The name of the model with all characters that are not allowed in a C identifier replaced by _.
std::string identifier_of(const std::string& name) {
  std::string out;
  for (const char c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    const bool digit = c >= '0' && c <= '9';
    out += letter || (digit && !out.empty()) ? c : '_';
  }
  return out.empty() ? "mechanism" : out;
}

/// The mechanism as the text of a drawing, with the shapes that touch.
std::string drawing_of(const Model& model) {
  Description description = model.description();
  const bool touches = has_shapes_that_touch(model);
  const auto is_superfluous = [touches](const ShapeDescription& shape) {
    return !touches || shape.role != ShapeDescription::Role::collision;
  };
  std::erase_if(description.shapes, is_superfluous);
  for (BodyDescription& body : description.bodies) std::erase_if(body.shapes, is_superfluous);
  std::ostringstream out;
  write_drawing(ModelBuilder(std::move(description)).build(), out);
  return out.str();
}

}  // namespace

std::vector<FmuFile> fmu_files(const Model& model, const ExportOptions& options, std::string binary) {
  if (options.kinds.empty())
    throw std::invalid_argument("an FMU needs a kind: model exchange, co-simulation or both");
  for (const Kind kind : options.kinds) check_supported(model, options.settings, kind);
  const std::string drawing = drawing_of(model), settings = to_text(options.settings);
  const Model read = ModelBuilder(read_drawing_text(drawing, drawing_resource)).build();
  const std::string identifier = identifier_of(model.name());
  const bool three = options.version == Version::fmi3;
  std::vector<FmuFile> files{
      {"modelDescription.xml", model_description(read, VariableTable(read, options.settings), options.version,
                                                 options.kinds, identifier, token_of(drawing, settings))},
      {std::string("binaries/") + (three ? platform_3 : platform_2) + "/" + identifier + ".so",
       std::move(binary)},
      {std::string("resources/") + drawing_resource, drawing},
      {std::string("resources/") + settings_resource, settings}};
  for (const auto& [name, text] : sources)
    files.push_back({"sources/" + std::string(name), std::string(text)});
  return files;
}

}  // namespace axode::fmi
