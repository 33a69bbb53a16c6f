#include "apps/files/model_options.hpp"

#include <CLI/CLI.hpp>

#include "apps/shell/choice.hpp"
#include "axode/contact/floor.hpp"

namespace axode::command {
namespace {

constexpr std::array<std::pair<std::string_view, Base>, 2> bases{
    {{"fixed", Base::fixed}, {"free", Base::free}}};

}  // namespace

Base ModelOptions::held() const { return base.empty() ? Base::as_described : choose("--base", base, bases); }

void add_model_options(CLI::App& command, ModelOptions& options, Files files, const char* name) {
  if (files == Files::one) {
    const auto keep = [&options](const std::string& file) { options.files = {file}; };
    command.add_option_function<std::string>(name, keep, "A drawing (.toml), a URDF or SDFormat")
        ->required()
        ->type_name("FILE");
  } else {
    command.add_option(name, options.files, "Drawings (.toml), URDFs and SDFormat")
        ->required()
        ->type_name("FILE ...");
  }
  command.add_option("--base", options.base, "Joint of the base: fixed, or free; default: that of the file")
      ->type_name(words(bases));
  command.add_flag("--strict", options.strict, "Treat warnings as errors");
}

void add_floor_option(CLI::App& command, ModelOptions& options) {
  command
      .add_option("--floor", options.floor, "Put the mechanism on a floor across gravity, at this height, m")
      ->type_name("NUMBER");
}

std::vector<Model> load_all(const ModelOptions& options) {
  std::vector<Model> models;
  const Base base = options.held();
  for (const std::string& file : options.files)
    models.push_back(axode::load(file, base, options.strictness()));
  if (options.floor)
    for (Model& model : models) model = with_floor(model, *options.floor);
  return models;
}

Model load(const ModelOptions& options) { return load_all(options).front(); }

}  // namespace axode::command
