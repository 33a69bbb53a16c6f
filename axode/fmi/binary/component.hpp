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

/// The parts of the C interfaces of FMI 2.0 and 3.0 that both versions have.
namespace axode::fmi {

/// The status that a function returns to the master, with the numbers of the standard.
enum Status : int { ok, warning, discard, error, fatal };

/// The pointer that a master receives as its instance points to a Component.
struct Component {
  std::unique_ptr<Instance> instance;
  std::function<void(Status, const char*)> log;
};

inline Status failed(const Component& component, Status status, const char* message) noexcept {
  if (component.log) component.log(status, message);
  return status;
}

/// Calls f(instance), and turns exceptions into a status with a message for the log. The status is `discard`
/// if the master may try another state.
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
/// The answer of a function that has no meaning for mechanisms.
inline Status unsupported(void* component, const char* function) noexcept {
  return guarded(component,
                 [&](Instance&) { throw std::runtime_error(std::string(function) + " is not supported"); });
}
/// The answer of an access to n variables of a type that no variable has.
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

/// Makes an instance from the resources, or logs why there is none and returns null.
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

/// Saves the state of an instance in *state, which is null or a state that was saved before.
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
