#pragma once
#include <array>
#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"
#include "python/bindings/support/array.hpp"
#include "python/bindings/support/bound_model.hpp"
#include "python/bindings/support/choice.hpp"
#include "python/bindings/support/long_call.hpp"
#include "python/bindings/support/text.hpp"

namespace axode::python {

/// The approximate time of a computation for one state, µs; if it is long, other threads run meanwhile.
double linear_cost(const Model& model);     ///< cost of O(n): a recursion
double quadratic_cost(const Model& model);  ///< cost of O(n²): a matrix
double cubic_cost(const Model& model);      ///< cost of O(n³): a tensor
double loop_cost(const Model& model);       ///< cost of O(n² + m³): a system with m rows of loops

/// The numbers of an argument: either one item (such as nv velocities) for all states, or one for each.
class Items {
 public:
  Items(Numbers numbers, bool many, nb::ssize_t item_size)
      : numbers_(std::move(numbers)), size_(item_size), step_(many ? item_size : 0) {}
  std::span<const double> operator[](std::size_t k) const {
    return {numbers_.data() + static_cast<nb::ssize_t>(k) * step_, static_cast<std::size_t>(size_)};
  }
  std::span<const double> all() const { return {numbers_.data(), static_cast<std::size_t>(numbers_.size())}; }

 private:
  Numbers numbers_;
  nb::ssize_t size_, step_;
};

/// The states for which Python calls a function: one state, an array (nq,), or N states, an array (N, nq).
class States {
 public:
  /// Reads the states. Throws nb::value_error for a wrong shape, infinite numbers or NaN, and threads < 1.
  States(const BoundModel& model, ArrayLike q, int threads, const char* name = "q");

  const Model& model() const { return bound_; }
  bool many() const { return many_; }
  std::size_t count() const { return count_; }
  int threads() const { return threads_; }
  std::span<const double> q(std::size_t k) const { return q_[k]; }
  std::span<const double> q() const { return q_.all(); }

  /// Checks an argument of the call. If q is one state, an array (nq,), it must be one item, an array of the
  /// shape `item`. If q is N states, an array (N, nq), it must be an array of N items, with one more axis in
  /// front. `meaning` describes an item in messages.
  Items items(const char* name, ArrayLike given, const Shape& item, const char* meaning) const;
  /// Another argument of the call with nq numbers for each state.
  Items configurations(const char* name, ArrayLike given) const;
  /// Another argument of the call with nv numbers for each state.
  Items velocities(const char* name, ArrayLike given) const;

  /// A new array for the results: one item for one state of shape (nq,), otherwise N items.
  NewArray result(const Shape& item) const {
    return NewArray(many_ ? item.times(static_cast<nb::ssize_t>(count_)) : item);
  }

  /// Calls f(workspace, k) for every state k. `microseconds` is the cost of one state. If all states together
  /// take more than 20 µs, or if threads > 1, other Python threads can run during the call, and Ctrl-C ends
  /// it.
  template <class W = Workspace<>, class F> void each(double microseconds, const F& f) const {
    if (threads_ > 1 || takes_long(microseconds)) return on_cores<W>(f);
    const BoundModel::Lease<W> workspace(bound_);
    for (std::size_t k = 0; k < count_; ++k) run(k, [&] { f(*workspace, k); });
  }
  /// Calls f(), which computes state k; of several states, the message of an error names this one.
  template <class F> void run(std::size_t k, const F& f) const {
    if (!many_) return f();
    try {
      f();
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument("state " + std::to_string(k) + ": " + error.what());
    }
  }
  /// Calls f(). If the call takes more than 20 µs, other Python threads run meanwhile.
  template <class F> auto released(double microseconds, const F& f) const {
    std::optional<nb::gil_scoped_release> released;
    if (takes_long(microseconds)) released.emplace();
    return f();
  }
  /// Calls f(monitor) once for all states. If the states together take more than 20 µs, other Python threads
  /// can run during the call. f must call monitor(done, of) now and then, which notices Ctrl-C, and must end
  /// if it returns false.
  template <class F> auto unlocked(double microseconds, const F& f) const {
    LongCall call(takes_long(microseconds));
    const auto outcome = f(call.monitor());
    call.end();
    return outcome;
  }

  /// Calls f(k, should_continue) for every state k. f must call should_continue() now and then, which notices
  /// Ctrl-C, and must end if it returns false.
  template <class F> void each_long(double microseconds, const F& f) const {
    unlocked(microseconds, [&](const batch::Monitor& monitor) {
      const std::thread::id caller = std::this_thread::get_id();
      batch::MonitorThrottle throttle(monitor, count_);
      std::atomic<bool> stopped = false;
      const std::function<bool()> should_continue = [&] {
        if (std::this_thread::get_id() == caller && !stopped && !throttle.should_continue(0)) stopped = true;
        return !stopped;
      };
      return batch::in_portions(
          count_, 1, threads_, [&](std::size_t, std::size_t) { return should_continue(); },
          [&]() -> batch::Work {
            return [&](std::size_t k, std::size_t) { run(k, [&] { f(k, should_continue); }); };
          });
    });
  }

  /// Throws SingularError or NotFiniteError if some states failed. The error contains `result`, the array
  /// with the results of all states of the call. `found` says for each state whether and why it failed, and
  /// may be empty. A state for which `found` gives no reason has failed too if one of its results is not
  /// finite; its reason is then `otherwise`. The NaN of an operational-space inertia that does not exist is
  /// not a failure.
  void refuse(const std::vector<Solvability>& found, NewArray& result,
              const Solvability& otherwise = {.not_finite = true}) const;
  /// Throws an error of the type `error` of axode.errors. `refused` are the indices of the states that could
  /// not be computed, and `sentence` says why the first of them could not; the message has its index if there
  /// are several states. The error contains `result`, the array with the results of all states of the call.
  [[noreturn]] void raise(const char* error, const std::string& sentence,
                          const std::vector<std::size_t>& refused, NewArray& result) const;

 private:
  bool takes_long(double microseconds) const { return microseconds * static_cast<double>(count_) > 20; }

  template <class W, class F> void on_cores(const F& f) const {
    unlocked(100, [&](const batch::Monitor& monitor) {
      return batch::in_portions(count_, 1, threads_, monitor, [&]() -> batch::Work {
        return [&, workspace = std::make_shared<W>(model())](std::size_t k, std::size_t) {
          run(k, [&] { f(*workspace, k); });
        };
      });
    });
  }

  const BoundModel& bound_;
  bool many_;
  int threads_;
  std::size_t count_;
  Items q_;
};

/// An argument with several rows of nv numbers for each state.
class Rows {
 public:
  Rows(const States& states, const char* name, ArrayLike given, const char* meaning);
  int count() const { return count_; }
  std::span<const double> operator[](std::size_t k) const { return items_[k]; }

 private:
  int count_;
  Items items_;
};

/// Returns `given` as a dict after checking its keys: all of them must be in `keys`, and all keys in `needed`
/// must be there. Throws nb::value_error or nb::key_error, which name the argument.
template <std::size_t N>
nb::dict entries_of(nb::handle given, const std::string& where, const std::array<std::string_view, N>& keys,
                    std::initializer_list<const char*> needed) {
  if (!nb::isinstance<nb::dict>(given))
    throw nb::value_error((where + ": expected a dict, got " + type_of(given)).c_str());
  nb::dict entries = nb::borrow<nb::dict>(given);
  for (const auto& [key, value] : entries) choose(where + ": a key", key, keys, nb::key_error);
  for (const char* key : needed)
    if (!entries.contains(key)) throw nb::key_error((where + " has no " + key).c_str());
  return entries;
}

/// The part of a result `out` that belongs to state k: an item of the given shape.
inline std::span<double> item(const NewArray& out, std::size_t k, const Shape& shape) {
  const std::size_t size = static_cast<std::size_t>(shape.size());
  return {out.data() + k * size, size};
}

/// Computes an array of results for all states. f(workspace, k, out) must write the result of state k, an
/// array of the shape `shape`, to `out`. If f can fail, it returns a Solvability, which says whether and why
/// it did.
template <class F>
NewArray each_item(const States& states, double microseconds, const Shape& shape, const F& f) {
  NewArray out = states.result(shape);
  std::vector<Solvability> found;
  if constexpr (std::is_void_v<decltype(f(std::declval<Workspace<>&>(), 0, std::span<double>()))>) {
    states.each(microseconds,
                [&](Workspace<>& workspace, std::size_t k) { f(workspace, k, item(out, k, shape)); });
  } else {
    found.resize(states.count());
    states.each(microseconds, [&](Workspace<>& workspace, std::size_t k) {
      found[k] = f(workspace, k, item(out, k, shape));
    });
  }
  states.refuse(found, out);
  return out;
}

/// An argument that has nv numbers for each state, and the name of the argument.
struct Named {
  const char* name;
  ArrayLike given;
};
/// Computes an array of results for all states. f(workspace, q, x, ..., out) must write the result of one
/// state to `out`. Its arguments x, ... are the items for this state of the arguments `more`, such as v and
/// a, which have nv numbers for each state.
template <class F, class... More>
NewArray map_states(const BoundModel& model, int threads, double microseconds, const Shape& shape,
                    ArrayLike q, const F& f, const More&... more) {
  const States states(model, q, threads);
  const std::array<Items, sizeof...(More)> items{states.velocities(more.name, more.given)...};
  return [&]<std::size_t... I>(std::index_sequence<I...>) {
    return each_item(states, microseconds, shape,
                     [&](Workspace<>& workspace, std::size_t k, std::span<double> out) {
                       return f(workspace, states.q(k), items[I][k]..., out);
                     });
  }
  (std::index_sequence_for<More...>());
}

/// The arguments `loads` and `joint_losses` of a call, annotated in Python as `Sequence[Load] | None`.
struct LoadList {
  PyObject* given = nullptr;
};
/// Wrenches on frames. Each wrench is either the same in all states or given for each state.
class AppliedLoads {
 public:
  AppliedLoads(const States& states, LoadList given, bool joint_losses);
  bool none() const { return first_.empty() && !joint_losses_; }
  std::size_t count() const { return first_.size(); }
  /// Calls f(loads) with the loads of state k.
  template <class F> auto with(std::size_t k, const F& f) const {
    if (!varies_) return f(Loads<double>{first_, joint_losses_});
    const std::vector<AppliedWrench<double>> now = at(k);
    return f(Loads<double>{now, joint_losses_});
  }

 private:
  std::vector<AppliedWrench<double>> at(std::size_t k) const;

  std::vector<AppliedWrench<double>> first_;
  std::vector<Items> wrenches_;
  bool varies_ = false, joint_losses_;
};

}  // namespace axode::python

namespace nanobind::detail {

template <> struct type_caster<axode::python::LoadList> {
  NB_TYPE_CASTER(axode::python::LoadList, const_name("collections.abc.Sequence[axode.Load]"))
  bool from_python(handle source, uint32_t, cleanup_list*) noexcept {
    value.given = source.ptr();
    return true;
  }
};

}  // namespace nanobind::detail
