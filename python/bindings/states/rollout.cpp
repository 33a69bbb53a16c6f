#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <concepts>
#include <optional>

#include "axode/batch.hpp"
#include "axode/batch/contact_rollout.hpp"
#include "axode/drives.hpp"
#include "axode/integration.hpp"
#include "axode/integration/methods.hpp"
#include "axode/integration/momenta/simulate_contact.hpp"
#include "axode/view/mesh_hull.hpp"
#include "python/bindings/drives.hpp"
#include "python/bindings/states/specialised.hpp"
#include "python/bindings/states/states.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/conversions.hpp"

/// Motions from many initial states in steps of equal length, for the Python module axode.simulation.
namespace axode::python {

using namespace nb::literals;

namespace {

/// The input for K steps of all motions: initial velocities, step length (s), and forces tau or a drive.
struct Steps {
  std::span<const double> v, tau;
  const Drive* drive;
  nb::ssize_t K;
  double length;
  bool joint_losses;
  batch::DriveMotions drives = {};  ///< drives with states
};
template <class S, class M>
batch::Outcome roll(const M& model, const Steps& steps, int threads, std::span<const S> q,
                    std::span<const S> v, std::span<const S> tau, std::span<S> q_out, std::span<S> v_out,
                    const batch::Monitor& monitor) {
  const auto under = [&](const auto&... forces) {
    const auto with = [&](const auto&... more) {
      return batch::rollout<S>(model, q, v, forces..., steps.length, q_out, v_out, runge_kutta(4), threads,
                               monitor, steps.joint_losses, more..., steps.drives);
    };
    if constexpr (std::same_as<M, Model>)
      return with(batch::CompiledDynamics<S>{});
    else
      return with();
  };
  return steps.drive ? under(*steps.drive, static_cast<std::size_t>(steps.K)) : under(tau);
}
/// Computes the motions, with functions that were compiled for the model if `compiled` is not null.
batch::Outcome roll(const States& states, const BoundSpecialised* compiled, const Steps& steps,
                    std::span<double> q_out, std::span<double> v_out, const batch::Monitor& monitor) {
  const auto in_double = [&](const auto& model) {
    return roll<double>(model, steps, states.threads(), states.q(), steps.v, steps.tau, q_out, v_out,
                        monitor);
  };
  if (!compiled) return in_double(states.model());
  if (!compiled->is_single()) return in_double(std::get<Specialised<double>>(compiled->functions()));
  const auto cast = [](std::span<const double> x) { return std::vector<float>(x.begin(), x.end()); };
  std::vector<float> q(q_out.size()), v(v_out.size());
  const batch::Outcome outcome =
      roll<float>(std::get<Specialised<float>>(compiled->functions()), steps, states.threads(),
                  cast(states.q()), cast(steps.v), cast(steps.tau), q, v, monitor);
  std::ranges::copy(q, q_out.begin());
  std::ranges::copy(v, v_out.begin());
  return outcome;
}

/// The indices of the motions that could not continue.
std::vector<std::size_t> ended(const States& states, const NewArray& v, const Shape& shape) {
  std::vector<std::size_t> found;
  for (std::size_t n = 0; n < states.count(); ++n)
    if (!all_finite(item(v, n, shape))) found.push_back(n);
  return found;
}

/// The states of the drives of all motions: those at the start, if they are given, and the result.
class DriveStatesOfMotions {
 public:
  DriveStatesOfMotions(const States& states, Steps& steps, nb::handle x)
      : nx_(static_cast<nb::ssize_t>(states.model().drives().empty() ? 0 : DriveSystem(states.model()).nx())),
        out_(states.result({steps.K + 1, nx_})) {
    if (!x.is_none()) given_ = states.items("x", {x.ptr()}, {nx_}, "a number for each state of the drives");
    if (given_) steps.drives.x = given_->all();
    steps.drives.x_out = out_.all();
  }
  Array array() { return out_.array(); }

 private:
  nb::ssize_t nx_;
  NewArray out_;
  std::optional<Items> given_;
};

std::tuple<Array, Array, Array> motions_of(const States& states, const BoundSpecialised* compiled,
                                           Steps steps, nb::handle x) {
  const nb::ssize_t K = steps.K;
  if (compiled) compiled->check({"forward_dynamics"});
  const int nq = states.model().nq(), nv = states.model().nv();
  const Shape shape_v{K + 1, nv};
  NewArray q_out = states.result({K + 1, nq}), v_out = states.result(shape_v);
  DriveStatesOfMotions x_out(states, steps, x);
  const batch::Outcome outcome =
      states.unlocked(100.0 * static_cast<double>(K), [&](const batch::Monitor& monitor) {
        return roll(states, compiled, steps, q_out.all(), v_out.all(), monitor);
      });
  if (outcome.loops_open)
    states.raise("SingularError", "the loops do not stay closed; use a shorter step",
                 ended(states, v_out, shape_v), q_out);
  if (outcome.too_many_changes)
    states.raise("StatesError", "the statuses of drives change without end; use a shorter step",
                 ended(states, v_out, shape_v), q_out);
  if (!outcome.ok()) {
    std::vector<Solvability> found(states.count());
    for (std::size_t n = outcome.first; n < found.size(); ++n)
      if (!all_finite(item(v_out, n, shape_v))) found[n] = outcome.solvability;
    states.refuse(found, q_out);
  }
  Array q = q_out.array(), v = v_out.array();
  if (compiled && compiled->is_single())
    for (Array* of : {&q, &v}) of->array = of->array.attr("astype")("float32");
  return {q, v, x_out.array()};
}

/// The drive forces of all motions in an argument: nv numbers for each of K steps.
struct Forces {
  Numbers tau;
  nb::ssize_t K = 0;

  Forces(const States& states, ArrayLike given) : tau("tau", given) {
    const nb::ssize_t nv = states.model().nv(), N = static_cast<nb::ssize_t>(states.count());
    const int axis = states.many() ? 1 : 0;  // the axis of the steps
    if (tau.axes() == axis + 2) K = tau.length(axis);
    const Shape one{K, nv}, expected = states.many() ? one.times(N) : one;
    if (tau.axes() != axis + 2 || !tau.ends_with(expected))
      tau.wrong_shape(std::string(states.many() ? "(" + std::to_string(N) + ", K, " : "(K, ") +
                      std::to_string(nv) + "), nv numbers for each step");
  }
  std::span<const double> all() const { return {tau.data(), static_cast<std::size_t>(tau.size())}; }
};

std::tuple<Array, Array, Array> rollout_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike tau,
                                           double step, const BoundSpecialised* compiled, int threads,
                                           bool joint_losses, nb::handle x, double t) {
  const States states(m, q, threads);
  const Items velocities = states.velocities("v", v);
  const Forces forces(states, tau);
  return motions_of(states, compiled,
                    {velocities.all(), forces.all(), nullptr, forces.K, step, joint_losses, {.t = t}}, x);
}

std::tuple<Array, Array, Array> driven_rollout_of(const BoundModel& m, ArrayLike q, ArrayLike v,
                                                  const BoundDrive& drive, nb::ssize_t K, double step,
                                                  const BoundSpecialised* compiled, int threads,
                                                  bool joint_losses, nb::handle x) {
  const States states(m, q, threads);
  const Items velocities = states.velocities("v", v);
  check_drive(m, drive);
  return motions_of(states, compiled, {velocities.all(), {}, &drive.drive, K, step, joint_losses}, x);
}

/// Finds why motion n ended early, by simulating it again. Returns a text that begins with ": ", or an empty
/// text if it then succeeds.
std::string reason_of_end(const States& states, const ContactShapes& shapes, const Steps& steps,
                          std::size_t n) {
  const std::size_t K = static_cast<std::size_t>(steps.K), nq = static_cast<std::size_t>(states.model().nq()),
                    nv = static_cast<std::size_t>(states.model().nv());
  SimulationOptions options{.joint_losses = steps.joint_losses};
  options.drive = [&](double t, std::span<const double> q_t, std::span<const double> v_t,
                      std::span<double> out) {
    if (steps.drive) return (*steps.drive)(t, q_t, v_t, out);
    const std::size_t k = std::min(K - 1, static_cast<std::size_t>(t / steps.length + 1e-6));
    std::ranges::copy(steps.tau.subspan((n * K + k) * nv, nv), out.begin());
  };
  if (const std::size_t nx = steps.drives.x.size() / states.count(); nx > 0) {
    const std::span<const double> x = steps.drives.x.subspan(n * nx, nx);
    options.x.assign(x.begin(), x.end());
  }
  const std::string reason =
      simulate_contact(states.model(), shapes, states.q().subspan(n * nq, nq), steps.v.subspan(n * nv, nv),
                       static_cast<double>(K) * steps.length, steps.length, options)
          .stop_reason;
  return reason.substr(std::min(reason.find(": "), reason.size()));
}

std::tuple<Array, Array, Array, Array> motions_with_contact(const States& states, const ContactShapes& shapes,
                                                            Steps steps, nb::handle x) {
  const nb::ssize_t K = steps.K, nq = states.model().nq();
  const Shape shape_v{K + 1, states.model().nv()};
  NewArray q = states.result({K + 1, nq}), v = states.result(shape_v), certificates = states.result({K});
  DriveStatesOfMotions x_out(states, steps, x);
  const batch::Outcome outcome =
      states.unlocked(1000.0 * static_cast<double>(K), [&](const batch::Monitor& monitor) {
        const auto roll = [&](const auto&... forces) {
          return batch::rollout_with_contact(states.model(), shapes, states.q(), steps.v, forces...,
                                             steps.length, q.all(), v.all(), certificates.all(),
                                             states.threads(), monitor, steps.joint_losses, steps.drives);
        };
        return steps.drive ? roll(*steps.drive, static_cast<std::size_t>(K)) : roll(steps.tau);
      });
  if (!outcome.ok())
    states.raise(
        "StatesError",
        "the motion with contact cannot continue" + reason_of_end(states, shapes, steps, outcome.first),
        ended(states, v, shape_v), q);
  return {q.array(), v.array(), certificates.array(), x_out.array()};
}

std::tuple<Array, Array, Array, Array> contact_rollout_of(const BoundModel& m, const ContactShapes& shapes,
                                                          ArrayLike q, ArrayLike v, ArrayLike tau,
                                                          double step, int threads, bool joint_losses,
                                                          nb::handle x, double t) {
  const States states(m, q, threads);
  const Items velocities = states.velocities("v", v);
  const Forces forces(states, tau);
  return motions_with_contact(
      states, shapes, {velocities.all(), forces.all(), nullptr, forces.K, step, joint_losses, {.t = t}}, x);
}

std::tuple<Array, Array, Array, Array> driven_contact_rollout_of(const BoundModel& m,
                                                                 const ContactShapes& shapes, ArrayLike q,
                                                                 ArrayLike v, const BoundDrive& drive,
                                                                 nb::ssize_t K, double step, int threads,
                                                                 bool joint_losses, nb::handle x) {
  const States states(m, q, threads);
  const Items velocities = states.velocities("v", v);
  check_drive(m, drive);
  return motions_with_contact(states, shapes, {velocities.all(), {}, &drive.drive, K, step, joint_losses}, x);
}

}  // namespace

void add_rollout(nb::module_& module) {
  module.def("rollout_under", &rollout_of, "m"_a, "q"_a, "v"_a, "tau"_a, "step"_a, "compiled"_a = nb::none(),
             nb::kw_only(), "threads"_a = 1, "joint_losses"_a = false, "x"_a = nb::none(), "t"_a = 0.0,
             "See axode.rollout.");
  module.def("rollout_driven", &driven_rollout_of, "m"_a, "q"_a, "v"_a, "drive"_a, "steps"_a, "step"_a,
             "compiled"_a = nb::none(), nb::kw_only(), "threads"_a = 1, "joint_losses"_a = false,
             "x"_a = nb::none(), "See axode.rollout.");
  nb::class_<ContactShapes>(module, "ContactShapes",
                            "The collision shapes of a mechanism, see axode.rollout.");
  module.def(
      "contact_shapes", [](const BoundModel& m) { return ContactShapes(m, hull_of_mesh); }, "m"_a,
      nb::call_guard<nb::gil_scoped_release>(), "The collision shapes, whose meshes are read from files.");
  module.def(
      "has_contact", [](const BoundModel& m) { return usual_method(m) == "contact"; }, "m"_a,
      "Whether a mechanism moves with contact where nothing else is asked for.");
  module.def("contact_rollout_under", &contact_rollout_of, "m"_a, "shapes"_a, "q"_a, "v"_a, "tau"_a, "step"_a,
             nb::kw_only(), "threads"_a = 1, "joint_losses"_a = false, "x"_a = nb::none(), "t"_a = 0.0,
             "See axode.rollout.");
  module.def("contact_rollout_driven", &driven_contact_rollout_of, "m"_a, "shapes"_a, "q"_a, "v"_a, "drive"_a,
             "steps"_a, "step"_a, nb::kw_only(), "threads"_a = 1, "joint_losses"_a = false,
             "x"_a = nb::none(), "See axode.rollout.");
}

}  // namespace axode::python
