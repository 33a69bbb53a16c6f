#pragma once
#include <cstdint>
#include <string>

#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/place.hpp"
#include "axode/recursion/loads.hpp"

/// Checks of the arguments of public functions.
namespace axode {

template <class T> void check_state(const Model& model, const Workspace<T>& workspace, Numbers<T> q) {
  workspace.check(model);
  check_configuration(model, q);
}
template <class T>
void check_state(const Model& model, const Workspace<T>& workspace, Numbers<T> q, Numbers<T> v) {
  check_state(model, workspace, q);
  check_size("v", v.size(), static_cast<std::size_t>(model.nv()), "nv");
}
template <class T>
void check_state(const Model& model, const Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                 Numbers<T> a) {
  check_state(model, workspace, q, v);
  check_size("a", a.size(), static_cast<std::size_t>(model.nv()), "nv");
}

/// Throws std::invalid_argument if a result shares memory with an argument that is read while it is written.
template <class Out, class In>
void check_separate(const char* result, std::span<Out> out, const char* argument, std::span<In> in) {
  const auto begin = [](const auto& x) { return reinterpret_cast<std::uintptr_t>(x.data()); };
  if (begin(out) < begin(in) + in.size_bytes() && begin(in) < begin(out) + out.size_bytes())
    throw std::invalid_argument(std::string(result) + " shares memory with " + argument +
                                "; this result needs memory of its own");
}

/// One of several results of a call, with the name of the result: an array of nv^power numbers.
template <class T> struct Result {
  const char* name;
  std::span<T> x;
  int power;
};
/// Throws std::invalid_argument unless each result of a call has the size nv^power and memory of its own.
template <class T> void check_results(const Model& model, std::initializer_list<Result<T>> results) {
  static constexpr const char* meanings[] = {"1", "nv", "nv * nv", "nv * nv * nv"};
  for (const Result<T>* a = results.begin(); a != results.end(); ++a) {
    std::size_t size = 1;
    for (int k = 0; k < a->power; ++k) size *= static_cast<std::size_t>(model.nv());
    check_size(a->name, a->x.size(), size, meanings[a->power]);
    for (const Result<T>* b = results.begin(); b != a; ++b) check_separate(a->name, a->x, b->name, b->x);
  }
}

/// Throws std::invalid_argument if a gear of the model has losses, for functions that do not compute them.
inline void refuse_gears(const Model& model) {
  if (model.gears().empty()) return;
  throw std::invalid_argument(
      "the gear of joint \"" + velocity_names(model)[static_cast<std::size_t>(model.gears()[0].velocity)] +
      "\" loses a part of the force that it transmits; of the functions with joint_losses, inverse_dynamics, "
      "forward_dynamics, rollout and, in relative coordinates and without contact, simulate count such "
      "losses: set joint_losses to false, or gear_loss to 0");
}
/// Checks the external wrenches and the switch for joint losses in `loads`. Throws std::invalid_argument if a
/// wrench acts on a frame that does not exist. Unless `counts_gears` is set, also throws if joint losses are
/// switched on and a gear of the model has losses, because the calling function does not compute these.
template <class T> void check_loads(const Model& model, const Loads<T>& loads, bool counts_gears = false) {
  if (loads.joint_losses && !counts_gears) refuse_gears(model);
  for (const AppliedWrench<T>& load : loads.wrenches)
    if (load.frame < 0 || load.frame >= model.n_frames())
      throw std::invalid_argument("loads: a wrench acts on frame " + std::to_string(load.frame) +
                                  "; model \"" + model.name() + "\" has frames 0 to " +
                                  std::to_string(model.n_frames() - 1));
}

inline void check_place(const Model& model, int frame) {
  if (frame < 0 || frame >= model.n_frames())
    throw std::invalid_argument("frame is " + std::to_string(frame) + "; model \"" + model.name() +
                                "\" has frames 0 to " + std::to_string(model.n_frames() - 1));
}

/// Returns a place (a frame on a body) with its frame given by number instead of by name. Throws
/// std::invalid_argument if there is no such frame.
template <class T> Place<T> found(const Model& model, const Place<T>& place) {
  const int frame = place.name.empty() ? place.frame : model.frame_index(place.name);
  check_place(model, frame);
  return {frame, place.offset};
}

inline void check_order(int k, int order) {
  if (k < 0 || k > order)
    throw std::invalid_argument("order " + std::to_string(k) + " is not among 0 to " + std::to_string(order));
}

}  // namespace axode
