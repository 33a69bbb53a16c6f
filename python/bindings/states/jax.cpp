#include <nanobind/stl/string.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <shared_mutex>
#include <unordered_map>

#include "axode/batch/portions.hpp"
#include "axode/integration/sensitivities.hpp"
#include "axode/model/building/builder.hpp"
#include "axode/model/building/edited.hpp"
#include "python/bindings/states/state_function.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/xla_ffi.hpp"

/// Functions of states that the compiler XLA calls for axode.jax, from any thread and without Python.
/// Arguments are arrays with an item for each state, of float64 or float32 (computed in float64).
namespace axode::python {

using namespace nb::literals;

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// A copy of the mechanism without loops, couplings and prescribed motions.
Model tree_of(const Model& model) {
  if (model.loops().empty() && model.motions().empty()) return model;
  Description tree = model.description();
  tree.loops.clear();
  tree.couplings.clear();
  tree.motions.clear();
  return ModelBuilder(std::move(tree)).build();
}

/// Keeps the models that compiled programs of JAX use. A model is found by a key that is made of its
/// contents. Models are kept without loops, couplings and prescribed motions; axode.jax refuses models that
/// have them.
class Mechanisms {
 public:
  void add(const std::string& key, const Model& model) {
    Entry tree{tree_of(model), 0};
    const std::unique_lock lock(mutex_);
    ++all_.try_emplace(key, std::move(tree)).first->second.users;
  }
  void remove(const std::string& key) {
    const std::unique_lock lock(mutex_);
    if (const auto found = all_.find(key); found != all_.end() && --found->second.users == 0)
      all_.erase(found);
  }
  Model at(const std::string& key) const {
    const std::shared_lock lock(mutex_);
    const auto found = all_.find(key);
    if (found == all_.end())
      throw std::invalid_argument("m: this program was compiled for a model that is not in this process");
    return found->second.model;
  }

 private:
  struct Entry {
    Model model;
    int users;
  };
  mutable std::shared_mutex mutex_;
  std::unordered_map<std::string, Entry> all_;
};
Mechanisms& mechanisms() {
  static Mechanisms all;
  return all;
}

/// An array that XLA passes in a call. It has an item of several numbers for each state.
struct XlaOperand {
  const xla::Buffer& buffer;
  std::size_t states = 1, item = 1;

  XlaOperand(const xla::Buffer& given, int item_axes) : buffer(given) {
    for (std::int64_t k = 0; k < given.rank; ++k)
      (k < given.rank - item_axes ? states : item) *= static_cast<std::size_t>(given.lengths[k]);
  }
  bool is_double() const { return buffer.type == xla::Type::float64; }
  std::size_t size() const { return states * item; }
};

/// The numbers of an argument as doubles. float32 numbers are converted.
class Doubles {
 public:
  explicit Doubles(const XlaOperand& operand) {
    if (operand.is_double()) {
      numbers_ = {static_cast<const double*>(operand.buffer.data), operand.size()};
    } else {
      const float* const given = static_cast<const float*>(operand.buffer.data);
      own(std::vector<double>(given, given + operand.size()));
    }
  }
  std::span<const double> all() const { return numbers_; }
  void own(std::vector<double> numbers) {
    converted_ = std::move(numbers);
    numbers_ = converted_;
  }

 private:
  std::vector<double> converted_;
  std::span<const double> numbers_;
};

/// The memory for a result, as doubles. deliver() converts the numbers if the result is float32.
class Answer {
 public:
  explicit Answer(const XlaOperand& result) : result_(result) {
    if (!result.is_double()) converted_.resize(result.size());
    numbers_ =
        result.is_double() ? std::span(static_cast<double*>(result.buffer.data), result.size()) : converted_;
  }
  std::span<double> all() const { return numbers_; }
  std::span<double> operator[](std::size_t k) const {
    return numbers_.subspan(k * result_.item, result_.item);
  }
  void deliver() const {
    if (!result_.is_double())
      std::ranges::transform(converted_, static_cast<float*>(result_.buffer.data),
                             [](double x) { return static_cast<float>(x); });
  }

 private:
  XlaOperand result_;
  std::vector<double> converted_;
  std::span<double> numbers_;
};

/// A call from XLA: its arguments, results and attributes.
class Call {
 public:
  explicit Call(const xla::CallFrame& frame) : frame_(frame) {}

  std::string text(std::string_view name) const {
    const auto [kind, value] = attribute(name);
    if (kind != xla::AttributeKind::text) refuse_attribute(name);
    return {static_cast<const xla::Text*>(value)->data, static_cast<const xla::Text*>(value)->size};
  }
  template <class T> T number(std::string_view name, xla::Type type) const {
    const auto [kind, value] = attribute(name);
    const xla::Scalar* const scalar = static_cast<const xla::Scalar*>(value);
    if (kind != xla::AttributeKind::scalar || scalar->type != type) refuse_attribute(name);
    return *static_cast<const T*>(scalar->value);
  }
  XlaOperand argument(std::size_t k, int item_axes) const { return of(frame_.arguments, k, item_axes); }
  XlaOperand result(std::size_t k, int item_axes) const { return of(frame_.results, k, item_axes); }
  std::size_t results() const { return static_cast<std::size_t>(frame_.results.size); }
  /// Throws std::invalid_argument with the name of the function that is called.
  [[noreturn]] void refuse(const std::string& why) const {
    const auto [kind, value] = found("function");
    const auto* const name =
        kind == xla::AttributeKind::text ? static_cast<const xla::Text*>(value) : nullptr;
    throw std::invalid_argument((name ? std::string(name->data, name->size) : "an XLA call of axode") + ": " +
                                why);
  }

 private:
  [[noreturn]] void refuse_attribute(std::string_view name) const {
    refuse("the attribute \"" + std::string(name) + "\" is missing or of another type");
  }
  /// The attribute of a name; its value is null if there is none.
  std::pair<xla::AttributeKind, void*> found(std::string_view name) const {
    const xla::Attributes& all = frame_.attributes;
    for (std::int64_t k = 0; k < all.size; ++k)
      if (std::string_view(all.names[k]->data, all.names[k]->size) == name)
        return {all.kinds[k], all.values[k]};
    return {};
  }
  std::pair<xla::AttributeKind, void*> attribute(std::string_view name) const {
    const auto attribute = found(name);
    if (attribute.second == nullptr) refuse_attribute(name);
    return attribute;
  }
  XlaOperand of(const xla::Buffers& buffers, std::size_t k, int item_axes) const {
    if (k >= static_cast<std::size_t>(buffers.size)) refuse("too few arguments or results were given");
    const xla::Buffer& buffer = *buffers.all[k];
    if (buffer.rank < item_axes || (buffer.type != xla::Type::float64 && buffer.type != xla::Type::float32))
      refuse("argument or result " + std::to_string(k) +
             " must be an array of float64 or float32 with an axis for the items");
    return {buffer, item_axes};
  }

  const xla::CallFrame& frame_;
};

/// The states of a call: the model, the number of states, and q with its quaternions scaled to norm 1.
class StatesOf {
 public:
  StatesOf(const Call& call, const XlaOperand& q)
      : call_(call), model_(mechanisms().at(call.text("model"))), count_(q.states) {
    threads_ = static_cast<int>(call.number<std::int64_t>("threads", xla::Type::int64));
    size_is(q, static_cast<std::size_t>(model_.nq()));
  }
  const Model& model() const { return model_; }
  std::size_t count() const { return count_; }
  int threads() const { return threads_; }

  void size_is(const XlaOperand& operand, std::size_t item) const {
    if (operand.states != count_ || operand.item != item)
      call_.refuse("an array has " + std::to_string(operand.states) + " times " +
                   std::to_string(operand.item) + " numbers; expected " + std::to_string(count_) + " times " +
                   std::to_string(item));
  }
  /// Scales the quaternions in q to norm 1. Throws std::invalid_argument if a norm differs from 1 by more
  /// than the tolerance. A quaternion with a NaN is replaced by the identity; the results for it are set to
  /// NaN later.
  void normalize(Doubles& q, double tolerance) {
    if (model_.topology().quaternion_bodies.empty()) return;
    std::vector<double> numbers(q.all().begin(), q.all().end());
    for (std::size_t k = 0; k < count_; ++k)
      for (const int i : model_.topology().quaternion_bodies) {
        double* const a = &numbers[k * static_cast<std::size_t>(model_.nq()) +
                                   static_cast<std::size_t>(model_.joint(i).iq)];
        const double length = std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2] + a[3] * a[3]);
        if (std::abs(length - 1) <= 4 * std::numeric_limits<double>::epsilon()) continue;
        if (std::abs(length - 1) <= tolerance) {
          for (int c = 0; c < 4; ++c) a[c] /= length;
        } else if (std::isnan(length)) {
          std::fill_n(&a[0], 3, 0.0);
          a[3] = 1;
          undefined_.push_back(k);
        } else {
          throw std::invalid_argument("q: the quaternion of joint \"" + model_.joint(i).name +
                                      "\" has norm " + to_text(length) + "; it must be 1 to " +
                                      (tolerance < 1e-5 ? "1e-6" : "1e-4"));
        }
      }
    q.own(std::move(numbers));
  }
  /// Sets the results of states with a NaN in a quaternion to NaN, and delivers the results to XLA.
  void deliver(const Answer& answer) const {
    for (const std::size_t k : undefined_) std::ranges::fill(answer[k], nan);
    answer.deliver();
  }

 private:
  const Call& call_;
  Model model_;
  std::size_t count_;
  int threads_;
  std::vector<std::size_t> undefined_;
};

double tolerance_of(const XlaOperand& q) { return q.is_double() ? 1e-6 : 1e-4; }

/// Calls f(workspace, k) for every state k, on several threads.
void one_by_one(const Model& model, std::size_t count, int threads,
                const std::function<void(Workspace<>&, std::size_t)>& f) {
  batch::in_portions(count, 1, threads, {}, [&]() -> batch::Work {
    return [&, workspace = std::make_shared<Workspace<>>(model)](std::size_t k, std::size_t) {
      f(*workspace, k);
    };
  });
}

using Inputs = std::vector<std::pair<catalog::Input, Doubles>>;

/// Computes a function of the catalogue in the states first to first + count - 1.
void evaluate(const catalog::Function<double>& row, const Model& model, const Inputs& inputs,
              std::size_t states, std::size_t first, std::size_t count, bool losses, int threads,
              const Answer& answer) {
  const auto given = [&](std::size_t from, std::size_t n) {
    catalog::Arguments<double> some{.loads = {.joint_losses = losses}};
    for (const auto& [input, numbers] : inputs) {
      const std::size_t item = numbers.all().size() / states;
      catalog::numbers(some, input) = numbers.all().subspan(from * item, n * item);
    }
    return some;
  };
  if (row.lanes && !losses && count > 1 && model.nq() > 0) {
    const std::size_t item = answer.all().size() / states;
    (void)batch::run<double>(model, *catalog::Id::of(row.name), given(first, count),
                             answer.all().subspan(first * item, count * item), threads);
  } else {
    one_by_one(model, count, threads, [&](Workspace<>& workspace, std::size_t k) {
      const std::span<double> out = answer[first + k];
      if (!row.call(model, workspace, given(first + k, 1), out).ok()) std::ranges::fill(out, nan);
    });
  }
}

/// Calls f(parameters, first, count) for each run of successive states with the same inertial parameters.
template <class F> void each_run(std::span<const double> parameters, std::size_t states, const F& f) {
  const std::size_t item = states == 0 ? 0 : parameters.size() / states;
  for (std::size_t first = 0, end = 0; first < states; first = end) {
    const std::span<const double> own = parameters.subspan(first * item, item);
    for (end = first + 1; end < states && std::ranges::equal(own, parameters.subspan(end * item, item));)
      ++end;
    f(own, first, end - first);
  }
}

void state_function(const Call& call) {
  const std::string name = call.text("function");
  const catalog::Function<double>* const row = catalog::find<Fast>(name);
  if (row == nullptr) throw std::invalid_argument("there is no function " + name);
  const auto item_axes = static_cast<int>(call.number<std::int64_t>("item_axes", xla::Type::int64));
  const XlaOperand of_q = call.argument(0, 1), result = call.result(0, item_axes);
  StatesOf states(call, of_q);
  const Model& model = states.model();
  states.size_is(result, row->size(model, 0));

  Inputs inputs;
  for (const catalog::Input input : catalog::inputs_of_numbers)
    if (row->takes_input(input)) {
      const XlaOperand operand = call.argument(inputs.size(), 1);
      if (input != catalog::Input::q) states.size_is(operand, static_cast<std::size_t>(model.nv()));
      inputs.emplace_back(input, operand);
    }
  states.normalize(inputs.front().second, tolerance_of(of_q));

  const bool losses = call.number<bool>("joint_losses", xla::Type::boolean);
  const Answer answer(result);
  if (call.number<bool>("parameters", xla::Type::boolean)) {
    const XlaOperand operand = call.argument(inputs.size(), 1);
    states.size_is(operand, 10 * static_cast<std::size_t>(model.n_bodies()));
    each_run(Doubles(operand).all(), states.count(),
             [&](auto parameters, std::size_t first, std::size_t count) {
               evaluate(*row, with_parameters(model, parameters), inputs, states.count(), first, count,
                        losses, states.threads(), answer);
             });
  } else if (states.count() > 0) {
    evaluate(*row, model, inputs, states.count(), 0, states.count(), losses, states.threads(), answer);
  }
  states.deliver(answer);
}

void motion(const Call& call) {
  const std::string name = call.text("function");
  const bool jvp = name == "rollout_jvp", vjp = name == "rollout_vjp";
  const double step = call.number<double>("step", xla::Type::float64);
  const XlaOperand of_q = call.argument(0, 1), of_tau = call.argument(2, 2);
  StatesOf states(call, of_q);
  const Model& m = states.model();
  const std::size_t K = static_cast<std::size_t>(of_tau.buffer.lengths[of_tau.buffer.rank - 2]),
                    nv = static_cast<std::size_t>(m.nv());
  const auto given = [&](std::size_t k, int axes, std::size_t size) {
    const XlaOperand operand = call.argument(k, axes);
    states.size_is(operand, size);
    return Doubles(operand);
  };
  Doubles q(of_q);
  states.normalize(q, tolerance_of(of_q));
  const Doubles v = given(1, 1, nv), tau = given(2, 2, K * nv);
  std::vector<Doubles> more;  // a direction for rollout_jvp, or weights for rollout_vjp
  if (jvp) more = {given(3, 1, nv), given(4, 1, nv), given(5, 2, K * nv)};
  if (vjp) more = {given(3, 2, (K + 1) * nv), given(4, 2, (K + 1) * nv)};
  std::vector<Answer> answers;
  for (std::size_t k = 0; k < call.results(); ++k) answers.emplace_back(call.result(k, vjp && k < 2 ? 1 : 2));

  if (!jvp && !vjp && m.nq() > 0) {
    (void)batch::rollout<double>(m, q.all(), v.all(), tau.all(), step, answers.at(0).all(),
                                 answers.at(1).all(), runge_kutta(4), states.threads());
  } else if (m.nv() > 0) {
    const auto item = [&](const Doubles& numbers, std::size_t k) {
      const std::size_t size = numbers.all().size() / states.count();
      return numbers.all().subspan(k * size, size);
    };
    one_by_one(m, states.count(), states.threads(), [&](Workspace<>&, std::size_t k) {
      if (jvp)
        (void)rollout_jvp(m, item(q, k), item(v, k), item(tau, k), step, item(more[0], k), item(more[1], k),
                          item(more[2], k), answers.at(0)[k], answers.at(1)[k]);
      else
        (void)rollout_vjp(m, item(q, k), item(v, k), item(tau, k), step, item(more[0], k), item(more[1], k),
                          {answers.at(0)[k], answers.at(1)[k], answers.at(2)[k]});
    });
  }
  for (const Answer& answer : answers) states.deliver(answer);
}

xla::Error* error(const xla::CallFrame& frame, xla::ErrorCode code, const char* message) {
  xla::NewError made{{sizeof(xla::NewError), nullptr}, message, code};
  return frame.api->new_error(&made);
}

/// A function with the signature that XLA, the compiler of JAX, calls. It calls f and converts exceptions to
/// errors of XLA. XLA may also call it only to ask for the version of the interface; the answer is the
/// version of xla_ffi.hpp, or an older one that XLA states.
template <void (*f)(const Call&)> xla::Error* handler(xla::CallFrame* frame) {
  if (frame->sized.extensions != nullptr) {
    const auto* const asked = static_cast<const xla::MetadataRequest*>(frame->sized.extensions);
    if (asked->kind == xla::MetadataRequest::expected) {
      const int theirs = frame->api != nullptr ? frame->api->version.minor : xla::first_minor_version;
      asked->metadata->version = {
          {sizeof(xla::Version), nullptr}, xla::major_version, std::min(theirs, xla::minor_version)};
      asked->metadata->traits = 0;
      return nullptr;
    }
  }
  if (frame->stage != xla::Stage::execute) return nullptr;
  try {
    f(Call(*frame));
    return nullptr;
  } catch (const std::invalid_argument& wrong) {
    return error(*frame, xla::ErrorCode::invalid_argument, wrong.what());
  } catch (const std::exception& wrong) {
    return error(*frame, xla::ErrorCode::internal, wrong.what());
  }
}

nb::capsule capsule(xla::Handler* of) { return nb::capsule(reinterpret_cast<void*>(of)); }

/// The structure of a model as a Python dict. For each joint screw it has the body, the index of the velocity
/// that moves it, and the ratio by which this velocity moves it; for each body the predecessor; and for each
/// frame the body.
nb::dict structure(const BoundModel& m) {
  nb::list bodies, velocities, ratios, parents, frames;
  for (int i = 1; i <= m->n_bodies(); ++i) {
    const Joint& joint = m->joint(i);
    parents.append(m->body(i).predecessor);
    for (int k = m->first_screw(i); k < m->first_screw(i + 1); ++k) {
      bodies.append(i);
      velocities.append(m->topology().iv[static_cast<std::size_t>(i)] + k - m->first_screw(i));
      ratios.append(joint.leader ? joint.leader->ratio : 1.0);
    }
  }
  for (const Frame& frame : m->frames()) frames.append(frame.body);
  nb::dict all;
  all["screw_body"] = bodies;
  all["screw_velocity"] = velocities;
  all["screw_ratio"] = ratios;
  all["parent"] = parents;
  all["frame_body"] = frames;
  return all;
}

}  // namespace

void add_jax(nb::module_& jax) {
  jax.def(
      "handlers",
      [] {
        nb::dict all;
        all["axode_state_function"] = capsule(&handler<&state_function>);
        all["axode_motion"] = capsule(&handler<&motion>);
        return all;
      },
      nb::sig("def handlers() -> dict[str, object]"));
  jax.def(
      "add", [](const std::string& key, const BoundModel& m) { mechanisms().add(key, *m); }, "key"_a, "m"_a);
  jax.def(
      "remove", [](const std::string& key) { mechanisms().remove(key); }, "key"_a);
  jax.def("structure", &structure, "m"_a, nb::sig("def structure(m: object) -> dict[str, list[typing.Any]]"));
}

}  // namespace axode::python
