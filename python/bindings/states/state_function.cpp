#include "python/bindings/states/state_function.hpp"

#include "axode/eigen.hpp"
#include "axode/fast/fast.hpp"
#include "axode/table/check_counts.hpp"
#include "python/bindings/support/conversions.hpp"

namespace axode::python {
namespace {

using namespace nb::literals;
using catalog::Choice;
using catalog::Entry;
using catalog::Extent;
using catalog::Input;

/// The axes that an entry of a result has in an array of numpy.
Shape axes_of(Entry entry) {
  switch (entry) {
    case Entry::number: return {};
    case Entry::vector: return {3};
    case Entry::pose: return {4, 4};
    case Entry::inertia: return {6, 6};
    default: return {6};
  }
}

double cost_of(catalog::Cost cost, const Model& model) {
  switch (cost) {
    case catalog::Cost::linear: return linear_cost(model);
    case catalog::Cost::quadratic: return quadratic_cost(model);
    case catalog::Cost::cubic: break;
  }
  return cubic_cost(model);
}

/// Expands items in place, for example poses of 12 numbers to 4 × 4 matrices of 16. Items of `packed` numbers
/// each lie at the beginning of `numbers`; they become items of `unpacked` numbers, beginning with the last
/// one. f writes the matrix of one item.
template <int packed, int unpacked, class F> void unpack(std::span<double> numbers, const F& f) {
  for (std::size_t k = numbers.size() / unpacked; k-- > 0;) {
    std::array<double, packed> x;
    std::copy_n(numbers.data() + k * packed, packed, x.begin());
    f(x, numbers.data() + k * unpacked);
  }
}
void unpack(Entry entry, std::span<double> numbers) {
  if (entry == Entry::pose)
    unpack<12, 16>(numbers, [](const auto& x, double* to) {
      for (std::size_t r = 0; r < 4; ++r)
        for (std::size_t c = 0; c < 4; ++c) to[4 * r + c] = r < 3 ? x[3 * c + r] : c < 3 ? 0 : 1;
    });
  if (entry == Entry::inertia)
    unpack<10, 36>(numbers, [](const auto& x, double* to) {
      const Inertia<> M{x[0], {x[1], x[2], x[3]}, {x[4], x[5], x[6], x[7], x[8], x[9]}};
      Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> matrix(to);
      matrix = to_eigen(M);
    });
}

}  // namespace

StateFunction::StateFunction(const char* name)
    : id_(*catalog::Id::of(name)),
      rows_{catalog::find<BodyFixed>(name), catalog::find<Spatial>(name), catalog::find<Hybrid>(name),
            catalog::find<Mixed>(name), catalog::find<Fast>(name)} {
  for (const ArgumentOfState& one : arguments_of_state)
    if (one.input != Input::q && rows_[0]->takes_input(one.input)) takes_.push_back(one);
}

const catalog::Function<double>& StateFunction::row(const Algorithm& algorithm) const {
  return *rows_[algorithm.representation ? static_cast<std::size_t>(*algorithm.representation)
                                         : rows_.size() - 1];
}

NewArray StateFunction::run(const BoundModel& m, const Arguments& given, const Row& row) const {
  catalog::check_counts(row, *m, catalog::Caller::whole);
  const bool counts_loops = !m->loops().empty() && row.call_with_loops != nullptr;
  const States states(m, given.q, given.threads);
  std::vector<Items> taken;
  for (const ArgumentOfState& one : takes_)
    taken.push_back(states.velocities(name_of(one.input), given.*one.argument));
  const AppliedLoads loads(states, given.loads, given.joint_losses);

  Shape shape{};
  const auto append = [&](nb::ssize_t length) {
    shape.length[static_cast<std::size_t>(shape.axes++)] = length;
  };
  if (row.symbols.size() > 1) append(static_cast<nb::ssize_t>(row.symbols.size()));
  for (const Extent extent : row.shape)
    append(static_cast<nb::ssize_t>(catalog::value_of(extent, *m, loads.count())));
  const Shape entry = axes_of(row.entry);
  for (int k = 0; k < entry.axes; ++k) append(entry.length[static_cast<std::size_t>(k)]);
  NewArray out = states.result(shape);

  const double cost = cost_of(row.cost, *m);
  const std::size_t size = row.size(*m, loads.count());
  std::vector<Solvability> found;
  Solvability otherwise{.not_finite = true};
  const bool in_lanes = states.many() && row.lanes && loads.none() && !counts_loops &&
                        (row.choice != Choice::recursion || !given.algorithm.representation);
  if (m->nq() > 0 && (given.instead != nullptr || in_lanes)) {  // these functions find the number of states
                                                                // from the size of q
    catalog::Arguments<double> all{.q = states.q()};
    for (std::size_t i = 0; i < taken.size(); ++i) catalog::numbers(all, takes_[i].input) = taken[i].all();
    const batch::Outcome outcome = states.unlocked(cost, [&](const batch::Monitor& monitor) {
      const std::span<double> result = out.all().first(states.count() * size);
      return given.instead ? (*given.instead)(all, result, monitor)
                           : batch::run<double>(*m, id_, all, result, given.threads, monitor);
    });
    if (!outcome.ok()) otherwise = outcome.solvability;
  } else {
    found.resize(states.count());
    const auto call_one = [&](const auto& call, auto& workspace, std::size_t k) {
      catalog::Arguments<double> one{
          .q = states.q(k), .place = given.place, .base = given.base, .form = given.form, .at = given.at};
      for (std::size_t i = 0; i < taken.size(); ++i) catalog::numbers(one, takes_[i].input) = taken[i][k];
      found[k] = loads.with(k, [&](const Loads<double>& now) {
        one.loads = now;
        return call(*m, workspace, one, out.all().subspan(k * size, size));
      });
    };
    if (counts_loops)
      states.each<LoopWorkspace<>>(loop_cost(*m), [&](auto& workspace, std::size_t k) {
        call_one(row.call_with_loops, workspace, k);
      });
    else
      states.each(cost, [&](Workspace<>& workspace, std::size_t k) { call_one(row.call, workspace, k); });
  }
  unpack(row.entry, out.all());
  states.refuse(found, out, otherwise);
  return out;
}

Array StateFunction::operator()(const BoundModel& m, const Arguments& given) const {
  const Row& called = row(given.algorithm);
  NewArray out = run(m, given, called);
  return called.columns ? out.transposed() : out.array();
}

Array StateFunction::in_rows(const BoundModel& m, const Arguments& given) const {
  return run(m, given, row(given.algorithm)).array();
}

nb::object StateFunction::all(const BoundModel& m, const Arguments& given) const {
  const std::string record = record_of(id_.words());
  if (record.empty()) return nb::cast((*this)(m, given));
  const Row& called = row(given.algorithm);
  NewArray out = run(m, given, called);
  nb::list parts;
  const int axes = static_cast<int>(called.shape.size()) + axes_of(called.entry).axes;
  for (std::size_t k = 0; k < called.symbols.size(); ++k)
    parts.append(nb::cast(out.part(static_cast<nb::ssize_t>(k), axes, called.columns)));
  if (record == "tuple") return nb::tuple(parts);
  return nb::module_::import_("axode.records").attr(record.c_str())(*parts);
}

std::string record_of(const catalog::Words& row) {
  const bool of_forces = row.derivative_of == "inverse_dynamics";
  const std::string family = of_forces                                 ? "InverseDynamics"
                             : row.derivative_of == "forward_dynamics" ? "ForwardDynamics"
                             : row.derivative_of == "momentum_form"    ? "MomentumForm"
                                                                       : "Motion";
  switch (row.symbols.size()) {
    case 1: return "";
    case 2: return row.derivative_of.empty() ? "tuple" : "StateDerivatives";
    case 3: return family + (family == "Motion" ? "Change" : "Derivatives");
    default: return family + (family.ends_with("Dynamics") ? "Hessian" : "Derivatives");
  }
}

std::string signature(const catalog::Words& row, const char* self, const std::string& options) {
  std::string text = "def " + std::string(row.name) + "(" + self + ", ";
  for (const Input input : parameters_of(row)) {
    text += name_of(input);
    text += catalog::is_of_numbers(input) ? ": numpy.typing.ArrayLike, "
            : input == Input::form ? ": " + std::string(Words<CoriolisForm>::name.text) + " = 'christoffel', "
                                   : ": str | int, ";
  }
  const std::string record = record_of(row), array = "numpy.typing.NDArray[numpy.float64]";
  return text + options + ") -> " +
         (record.empty()      ? array
          : record == "tuple" ? "tuple[" + array + ", " + array + "]"
                              : "axode." + record);
}

std::string documented(const char* name, std::string doc) {
  const std::string line = to_string(catalog::Id::of(name)->words().counts) + "\n\n";
  const std::size_t example = std::min(doc.find(">>>"), doc.size());
  return doc.insert(example, line);
}

}  // namespace axode::python
