#pragma once
#include <cstddef>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "axode/fmi/instance.hpp"
#include "axode/fmi/resources.hpp"

/// The parts of the C interfaces that FMI 2.0 and FMI 3.0 have in common.
namespace axode::fmi {

/// The status that an interface function returns to the importing program, a number of the FMI standard.
enum Status : int { ok, warning, discard, error, fatal };

/// An instance of an FMU with its log function. The importing program holds a pointer to it.
struct Component {
  std::unique_ptr<Instance> instance;
  std::function<void(Status, const char*)> log;
};

inline Status failed(const Component& component, Status status, const char* message) noexcept {
  if (component.log) component.log(status, message);
  return status;
}

/// Calls f(instance) and converts an exception to a message in the log and a status of FMI: `discard` if the
/// rates of the state cannot be computed (NoRates), after which the importing program may try another state,
/// and `error` for all other exceptions.
template <class F> Status guarded(void* component, const F& f) noexcept {
  if (component == nullptr) return error;
  auto& its = *static_cast<Component*>(component);
  try {
    f(*its.instance);
    return ok;
  } catch (const NoRates& none) {
    return failed(its, discard, none.what());
  } catch (const std::exception& fault) {
    return failed(its, error, fault.what());
  }
}
/// For functions of FMI that FMUs of mechanisms do not support: logs a message and returns `error`.
inline Status unsupported(void* component, const char* function) noexcept {
  return guarded(component,
                 [&](Instance&) { throw std::runtime_error(std::string(function) + " is not supported"); });
}
/// Returns the status of an access to n variables of a type that no variable has: `error` unless n is 0.
inline Status no_variables(void* component, const unsigned* references, std::size_t n) noexcept {
  return guarded(component, [&](Instance&) {
    if (n > 0)
      throw std::invalid_argument("value reference " + std::to_string(references[0]) +
                                  " has another type; all variables are real numbers (Float64)");
  });
}

inline std::string contents(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error(file.string() + " cannot be read");
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Makes an instance from the files in the folder `resources`. `token` must be the hash of these files, by
/// which they are recognised as those of the FMU. If this fails, logs the reason and returns null.
inline void* make_component(Kind kind, const char* token, const std::filesystem::path& resources,
                            std::function<void(Status, const char*)> log) noexcept {
  Component made{nullptr, std::move(log)};
  try {
    const std::string drawing = contents(resources / drawing_resource),
                      settings = contents(resources / settings_resource);
    const std::string shown = token == nullptr ? "" : token, own = token_of(drawing, settings);
    if (shown != own)
      throw std::invalid_argument("the master shows the token \"" + shown + "\", and the FMU has \"" + own +
                                  '"');
    made.instance = std::make_unique<Instance>(kind, drawing, settings);
    return std::make_unique<Component>(std::move(made)).release();
  } catch (const std::exception& fault) {
    failed(made, error, fault.what());
    return nullptr;
  }
}
inline void free_component(void* component) noexcept { delete static_cast<Component*>(component); }

/// Saves the state of an instance in *state, which is null or a state that was saved before and is replaced.
inline Status save(void* component, void** state) noexcept {
  return guarded(component, [&](Instance& its) {
    auto copy = std::make_unique<Instance>(its);
    delete static_cast<Instance*>(*state);
    *state = copy.release();
  });
}
inline Status restore(void* component, void* state) noexcept {
  return guarded(component, [&](Instance&) {
    if (state == nullptr) throw std::invalid_argument("there is no saved state");
    static_cast<Component*>(component)->instance =
        std::make_unique<Instance>(*static_cast<const Instance*>(state));
  });
}
inline Status free_state(void** state) noexcept {
  if (state == nullptr) return ok;
  delete static_cast<Instance*>(*state);
  *state = nullptr;
  return ok;
}

inline void check_count(std::size_t given, std::size_t expected, const char* what) {
  if (given != expected)
    throw std::invalid_argument("the master has " + std::to_string(given) + " " + what + ", and the FMU " +
                                std::to_string(expected));
}

}  // namespace axode::fmi
