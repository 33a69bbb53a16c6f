#include "python/bindings/states/states.hpp"

#include <algorithm>
#include <limits>

#include "python/bindings/support/choice.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/raise.hpp"

namespace axode::python {
namespace {

/// The number of items in an argument, its first axis; empty if it has the shape of one item, such as (nq,).
std::optional<std::size_t> rows(const Numbers& numbers, const Shape& item) {
  return numbers.axes() == item.axes ? std::nullopt
                                     : std::optional(static_cast<std::size_t>(numbers.length(0)));
}

Items states_in(const Model& model, const char* name, ArrayLike given, bool& many, std::size_t& count) {
  const Shape item{model.nq()};
  Numbers q(name, given);
  if (!q.ends_with(item) || q.axes() > 2)
    q.wrong_shape(item.text() + " or (N, " + std::to_string(model.nq()) +
                  ") with nq = " + std::to_string(model.nq()) + " coordinates");
  const auto N = rows(q, item);
  many = N.has_value();
  count = N.value_or(1);
  return {std::move(q), many, item.size()};
}

int positive(int threads) {
  if (threads < 1)
    throw nb::value_error(("threads is " + std::to_string(threads) + "; expected 1 or more").c_str());
  return threads;
}

}  // namespace

double linear_cost(const Model& model) { return 0.2 * model.n_bodies(); }
double quadratic_cost(const Model& model) { return linear_cost(model) + 0.01 * model.nv() * model.nv(); }
double cubic_cost(const Model& model) {
  return quadratic_cost(model) + 0.01 * model.nv() * model.nv() * model.nv();
}
double loop_cost(const Model& model) {
  const double rows = model.loops().rows;
  return quadratic_cost(model) + 0.001 * rows * rows * rows;
}

States::States(const BoundModel& model, ArrayLike q, int threads, const char* name)
    : bound_(model),
      many_(false),
      threads_(positive(threads)),
      count_(1),
      q_(states_in(model, name, q, many_, count_)) {}

Items States::items(const char* name, ArrayLike given, const Shape& item, const char* meaning) const {
  Numbers numbers(name, given);
  const Shape expected = many_ ? item.times(static_cast<nb::ssize_t>(count_)) : item;
  if (numbers.axes() != expected.axes || !numbers.ends_with(expected))
    numbers.wrong_shape(expected.text() +
                        (many_ ? ", " + std::to_string(count_) + " states, each with " : ", ") + meaning);
  return {std::move(numbers), many_, item.size()};
}

Items States::configurations(const char* name, ArrayLike given) const {
  return items(name, given, {model().nq()}, "nq numbers");
}

Items States::velocities(const char* name, ArrayLike given) const {
  return items(name, given, {model().nv()}, "nv numbers");
}

void States::refuse(const std::vector<Solvability>& found, NewArray& result,
                    const Solvability& otherwise) const {
  const bool solved =
      std::all_of(found.begin(), found.end(), [](const Solvability& each) { return each.ok(); });
  if (solved && all_finite(result.all())) return;
  std::vector<std::size_t> refused;
  Solvability first;
  const std::size_t size = count_ == 0 ? 0 : result.all().size() / count_;
  for (std::size_t k = 0; k < count_; ++k) {
    Solvability state = found.empty() ? Solvability{} : found[k];
    if (state.directions < 6) continue;  // such a frame has no inertia, and the result NaN says so
    if (state.ok() && !all_finite(result.all().subspan(k * size, size))) state = otherwise;
    if (state.ok()) continue;
    if (refused.empty()) first = state;
    refused.push_back(k);
  }
  if (refused.empty()) return;
  raise(first.not_finite ? "NotFiniteError" : "SingularError", to_string(model(), first), refused, result);
}

void States::raise(const char* error, const std::string& sentence, const std::vector<std::size_t>& refused,
                   NewArray& result) const {
  std::string where;
  if (many_) {
    where = "state " + std::to_string(refused.front());
    if (const std::size_t others = refused.size() - 1; others > 0)
      where += " and " + std::to_string(others) + (others > 1 ? " others" : " other");
    where += ": ";
  }
  raise_of_states(error, where + sentence, refused, result.array());
}

Rows::Rows(const States& states, const char* name, ArrayLike given, const char* meaning)
    : count_(0), items_([&] {
        const Numbers numbers(name, given);
        const int axis = states.many() ? 1 : 0;
        if (numbers.axes() != axis + 2)
          numbers.wrong_shape(std::string(states.many() ? "(N, k, nv), " : "(k, nv), ") + meaning);
        if (numbers.length(axis) > std::numeric_limits<int>::max())
          numbers.wrong_shape("with " + std::to_string(std::numeric_limits<int>::max()) + " rows at most");
        count_ = static_cast<int>(numbers.length(axis));
        return states.items(name, given, {count_, states.model().nv()}, meaning);
      }()) {}

AppliedLoads::AppliedLoads(const States& states, LoadList given, bool joint_losses)
    : joint_losses_(joint_losses) {
  const nb::handle list(given.given);
  if (!list.is_valid() || list.is_none()) return;
  if (!PyList_Check(list.ptr()) && !PyTuple_Check(list.ptr()))
    throw nb::value_error(
        (std::string("loads: expected a list of dicts with the keys frame, representation and "
                     "wrench, got ") +
         type_of(list))
            .c_str());
  std::size_t number = 0;
  for (const nb::handle load : list) {
    const std::string where = "loads[" + std::to_string(number++) + "]";
    const nb::dict entries =
        entries_of(load, where, std::array<std::string_view, 3>{"frame", "representation", "wrench"},
                   {"frame", "wrench"});
    const int frame =
        FrameName{nb::object(entries["frame"]).ptr()}.in(states.model(), (where + ".frame").c_str());
    const Representation representation =
        entries.contains("representation")
            ? Words<Representation>::value(choose((where + ".representation").c_str(),
                                                  entries["representation"], Words<Representation>::words))
            : Representation::body;
    Numbers wrench(where + ".wrench", {nb::object(entries["wrench"]).ptr()});
    const bool one = wrench.axes() == 1 && wrench.ends_with({6});
    const Shape each = Shape{6}.times(static_cast<nb::ssize_t>(states.count()));
    if (!one && !(states.many() && wrench.axes() == 2 && wrench.ends_with(each)))
      wrench.wrong_shape("(6,)" + (states.many() ? " or " + each.text() : "") +
                         ", moment (N m) before force (N)");
    const std::array<double, 6> zero{};  // the loads if there are no states
    const double* W = wrench.size() > 0 ? wrench.data() : zero.data();
    first_.emplace_back(frame, representation, vector_from(W), vector_from(W + 3));
    varies_ = varies_ || !one;
    wrenches_.emplace_back(std::move(wrench), !one, 6);
  }
}

std::vector<AppliedWrench<double>> AppliedLoads::at(std::size_t k) const {
  std::vector<AppliedWrench<double>> now = first_;
  for (std::size_t load = 0; load < now.size(); ++load) {
    const double* W = wrenches_[load][k].data();
    now[load].m = vector_from(W);
    now[load].f = vector_from(W + 3);
  }
  return now;
}

}  // namespace axode::python
