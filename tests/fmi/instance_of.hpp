#pragma once
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "axode/fmi.hpp"
#include "axode/io.hpp"

/// Instances of FMUs without a binary around them.
namespace axode::test {

/// A mechanism that comes with axode.
inline Model shipped(const std::string& file) { return load(AXODE_SOURCE_DIR "/examples/robots/" + file); }

/// An instance of the FMU of a mechanism.
inline fmi::Instance instance_of(const Model& model, fmi::Kind kind, const fmi::Settings& settings = {}) {
  std::ostringstream drawing;
  write_drawing(model, drawing);
  return {kind, drawing.str(), to_text(settings)};
}
/// The variables of that FMU.
inline fmi::VariableTable variables_of(const Model& model, const fmi::Settings& settings = {}) {
  std::ostringstream drawing;
  write_drawing(model, drawing);
  return {ModelBuilder(read_drawing_text(drawing.str(), "")).build(), settings};
}

/// The references of the variables of a role, or below of the variable with a name.
inline std::vector<unsigned> references(const fmi::VariableTable& table, fmi::Role role) {
  std::vector<unsigned> all;
  for (std::size_t k = 0; k < table.count(role); ++k)
    all.push_back(static_cast<unsigned>(table.first(role) + k));
  return all;
}
inline std::vector<unsigned> reference(const fmi::VariableTable& table, const std::string& name) {
  for (std::size_t r = 0; r < table.size(); ++r)
    if (table[r].name == name) return {static_cast<unsigned>(r)};
  throw std::invalid_argument("there is no variable " + name);
}

inline std::vector<double> values(fmi::Instance& instance, const std::vector<unsigned>& of) {
  std::vector<double> out(of.size());
  instance.get(of, out);
  return out;
}
/// Sets coordinates and velocities, and starts the instance at time 0.
inline void start(fmi::Instance& instance, const fmi::VariableTable& table, std::span<const double> q,
                  std::span<const double> v, std::optional<double> tolerance = {}) {
  instance.enter_initialization(0, tolerance);
  instance.set(references(table, fmi::Role::coordinate), q);
  instance.set(references(table, fmi::Role::velocity), v);
  instance.exit_initialization();
}

}  // namespace axode::test
