#include "tests/support/units.hpp"

#include <cmath>
#include <cstring>

#include "axode/constraints.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/functions.hpp"
#include "tests/support/random_loops.hpp"

/// Results do not depend on units. In other units of length, mass and time every number that a function
/// returns is multiplied by the factor of the unit that the function's row of the catalogue names.
namespace axode::test {
namespace {

using catalog::Entry, catalog::Extent, catalog::Function, catalog::Input;
using std::string, std::string_view;
using Numbers = std::vector<double>;
using Dimensions = std::vector<Dimension>;

std::vector<string_view> parts_of(string_view text, string_view separator) {
  std::vector<string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == string_view::npos) return parts;
    text.remove_prefix(end + separator.size());
  }
}
/// The dimensions in a list such as "N m for angles, N for lengths".
Dimensions list_of(string_view text) {
  Dimensions list;
  for (const string_view unit : parts_of(text, ", "))
    list.push_back(dimension_of(unit.substr(0, unit.find(" for "))));
  return list;
}
/// The dimensions of a quantity, angular and linear, by its symbol.
Dimensions list_of_symbol(string_view symbol) {
  if (symbol == "v" || symbol == "V") return list_of("rad/s, m/s");
  if (symbol == "a" || symbol == "V'") return list_of("rad/s^2, m/s^2");
  if (symbol == "X") return list_of("rad, m");
  if (symbol == "p'" || symbol == "tau" || symbol == "(C v)" || symbol == "g" || symbol == "Q")
    return list_of("N m, N");
  throw std::logic_error("no symbol of a quantity: " + string(symbol));
}
/// The dimension of a component of a direction (q, v, a, tau or p) whose coordinate has this dimension.
Dimension direction(string_view symbol, const Dimension& coordinate) {
  using namespace dimension;
  if (symbol == "q") return coordinate;
  if (symbol == "v") return coordinate * rate;
  if (symbol == "a") return coordinate * rate * rate;
  if (symbol == "tau") return energy / coordinate;
  if (symbol == "p") return energy * time / coordinate;
  throw std::logic_error("no symbol of a direction: " + string(symbol));
}

/// Reads from a row of the catalogue the dimension of each number that its function returns, for a model.
template <class T> class UnitsOf {
 public:
  UnitsOf(const Function<T>& row, const Model& model, std::size_t n_loads)
      : row_(row),
        directions_(direction_dimensions(model)),
        screws_(screw_dimensions(model)),
        n_parts_(row.symbols.size()) {
    for (const Extent axis : row.shape) extents_.push_back(value_of(axis, model, n_loads));
  }

  /// The dimensions of all `size` numbers.
  Dimensions of_all(std::size_t size) const {
    std::size_t entries = n_parts_;
    for (const std::size_t extent : extents_) entries *= extent;
    Dimensions all;
    if (entries == 0) return all;
    const std::size_t components = size / entries, per_part = size / n_parts_;
    EXPECT_EQ(components, static_cast<std::size_t>(catalog::numbers_of(row_.entry)));
    for (std::size_t k = 0; k < size; ++k) {
      std::vector<std::size_t> index(extents_.size());
      std::size_t rest = k % per_part / components;
      for (std::size_t axis = extents_.size(); axis-- > 0; rest /= extents_[axis])
        index[axis] = rest % extents_[axis];
      all.push_back(of(k / per_part, index, k % components));
    }
    return all;
  }

 private:
  bool six_vector() const {
    return row_.entry == Entry::twist || row_.entry == Entry::rate || row_.entry == Entry::wrench ||
           row_.entry == Entry::momentum;
  }
  static Dimension part_of_six(std::size_t component) {
    return component < 3 ? dimension::one : dimension::length;
  }

  Dimension of(std::size_t part, const std::vector<std::size_t>& index, std::size_t component) const {
    const std::vector<string_view> texts = parts_of(row_.units, "; ");
    const string_view text = texts[texts.size() == 1 ? 0 : part], symbol = row_.symbols[part];
    if (row_.entry == Entry::pose) return component < 9 ? dimension::one : dimension_of(text);
    if (row_.entry == Entry::inertia) return list_of(text).at(component < 1 ? 0 : component < 4 ? 1 : 2);

    const std::size_t per = text.find(" per ");
    const string_view numerator = text.substr(0, per),
                      denominator = per == string_view::npos ? string_view() : text.substr(per + 5);
    Dimension divisor;
    std::vector<char> left(index.size(), 1);  // the axes that belong to the numerator
    bool component_left = six_vector();
    const auto last = [&](auto&&... extents) {
      for (std::size_t axis = index.size(); axis-- > 0;)
        if (left[axis] && ((row_.shape[axis] == extents) || ...)) {
          left[axis] = 0;
          return axis;
        }
      throw std::logic_error(string(row_.name) + ": no axis for " + string(text));
    };
    if (denominator.starts_with("unit of the direction") ||
        denominator.starts_with("units of the directions")) {
      if (const std::size_t slash = symbol.find("/d"); slash != string_view::npos) {
        divisor = direction(symbol.substr(slash + 2), directions_[index[last(Extent::nv)]]);
      } else if (symbol.starts_with("by ")) {
        std::vector<string_view> names = parts_of(symbol.substr(3), ", ");
        for (std::size_t k = names.size(); k-- > 0;)
          divisor = divisor * direction(names[k], directions_[index[last(Extent::nv)]]);
      } else {  // one matrix for each direction of the configuration
        left[0] = 0, divisor = directions_[index[0]];
      }
    } else if (denominator == "unit of the velocity") {
      const std::size_t axis = last(Extent::nv, Extent::n_screws);
      divisor = direction("v", (row_.shape[axis] == Extent::nv ? directions_ : screws_)[index[axis]]);
    } else if (denominator == "unit of the parameter") {
      const std::size_t k = index[last(Extent::n_parameters)] % 10;
      divisor = list_of("kg, kg m, kg m^2")[k < 1 ? 0 : k < 4 ? 1 : 2];
    } else if (!denominator.empty()) {  // per unit of a component of a six-vector
      const bool in_entry = !std::count(row_.shape.begin(), row_.shape.end(), Extent::six);
      const std::size_t at = in_entry ? component : index[last(Extent::six)];
      if (in_entry) component_left = false;
      divisor = list_of(denominator).at(at < 3 ? 0 : 1);
    }

    if (numerator.find("of w ") != string_view::npos)
      return dimension::one / divisor;  // the weights w make the
                                        // numerator a number, see
                                        // weights()
    Dimensions list;
    if (numerator == "of J") {
      list = list_of("rad/s, m/s");
      divisor = divisor * direction("v", directions_[index[last(Extent::nv)]]);
    } else if (numerator.starts_with("of ")) {
      const bool by = symbol.starts_with("by ") || symbol == "dtau/dpi" || symbol == "da/dpi";
      const string_view from = by ? numerator.substr(3) : symbol.substr(1, symbol.find("/d") - 1);
      list = list_of_symbol(from);
    } else {
      list = list_of(numerator);
    }
    std::size_t lengths = 0, slots = 0;
    const auto count = [&](const Dimension& d) { ++slots, lengths += d == dimension::length; };
    for (std::size_t axis = 0; axis < index.size(); ++axis)
      if (left[axis]) {
        if (row_.shape[axis] == Extent::nv) count(directions_[index[axis]]);
        if (row_.shape[axis] == Extent::six) count(part_of_six(index[axis]));
      }
    if (component_left) count(part_of_six(component));
    EXPECT_EQ(list.size(), slots + 1) << text;
    return list.at(lengths) / divisor;
  }

  const Function<T>& row_;
  Dimensions directions_, screws_;
  std::size_t n_parts_;
  std::vector<std::size_t> extents_;
};

/// The weights of a row in other units, such that the weighted sum has no unit.
template <class T>
Numbers weights(const Function<T>& row, const Units& units, const Model& model, Numbers w) {
  const Dimensions directions = direction_dimensions(model);
  const bool accelerations = row.units.find("of w a") != string_view::npos;
  for (std::size_t c = 0; c < w.size(); ++c)
    w[c] /= units(direction(accelerations ? "a" : "tau", directions[c]));
  return w;
}

struct OtherUnits {
  Case how;
  Units units;
  string name;

  friend std::ostream& operator<<(std::ostream& out, const OtherUnits& other) { return out << other.name; }
};
std::vector<OtherUnits> other_units() {
  std::vector<OtherUnits> all;
  for (const Case& c : cases_with_fast()) {
    all.push_back({c, {.length = 0x1p-8, .mass = 0x1p-12, .time = 0x1p-4}, c.name + "_small"});
    all.push_back({c, {.length = 0x1p10, .mass = 0x1p-10, .time = 0x1p6}, c.name + "_large"});
  }
  return all;
}
class UnitsLaw : public testing::TestWithParam<OtherUnits> {};
INSTANTIATE_TEST_SUITE_P(Laws, UnitsLaw, testing::ValuesIn(other_units()),
                         [](const auto& info) { return info.param.name; });

TEST_P(UnitsLaw, MultiplyEveryNumberByTheUnitOfItsRow) {
  const Case& how = GetParam().how;
  const Units& units = GetParam().units;
  with_scalar(how, [&](auto scalar) {
    using T = decltype(scalar);
    for_seeds(30, [&](std::uint64_t seed) {
      Random<double> random(seed);
      const Description drawn = random_description(random, {.most_bodies = 8});
      const Model model = ModelBuilder(drawn).build(), other = ModelBuilder(in_units(units, drawn)).build();
      State<double> state = rounded(how, random_state(model, random));
      state.wrenches.emplace_back(model.n_frames() - 1, Representation::hybrid, random.vector(),
                                  random.vector());
      const State<double> other_state = in_units(units, model, state);
      Ask ask{.q = state.q, .v = state.v, .a = state.a};
      for (Numbers* const x : {&ask.tau, &ask.p, &ask.dq, &ask.dv, &ask.da, &ask.dtau, &ask.w})
        *x = cast<double>(cast<T>(random_numbers(random, model.nv())));
      ask.place = {model.n_frames() - 1, random.vector()}, ask.base = 1;
      Ask other_ask = in_units(units, model, ask);
      ask.loads = {state.wrenches, true}, other_ask.loads = {other_state.wrenches, true};
      Workspace<T> workspace(model);
      for (const Function<T>& row : functions_of<T>(how)) {
        SCOPED_TRACE(row.name);
        Ask weighed = other_ask;
        weighed.w = weights(row, units, model, ask.w);
        const auto call = [&](const Model& of, const Ask& with) {
          const Arguments<T> arguments(with);
          std::vector<T> out(row.size(of, with.loads.wrenches.size()));
          try {
            const Solvability status = row.call(of, workspace, arguments.given(), out);
            return std::pair(cast<double>(out), status);
          } catch (const std::domain_error&) {  // no body has mass
            return std::pair(Numbers(), Solvability{});
          }
        };
        const auto [x, status] = call(model, ask);
        const auto [y, other_status] = call(other, weighed);
        EXPECT_EQ(other_status, status);
        ASSERT_EQ(y.size(), x.size());
        if (x.empty()) continue;
        const Dimensions dimensions = UnitsOf<T>(row, model, ask.loads.wrenches.size()).of_all(x.size());
        for (std::size_t k = 0; k < x.size(); ++k) {
          if (std::isnan(x[k]) && std::isnan(y[k])) continue;
          const auto has_fewer_digits = [](double z) {
            return std::fpclassify(static_cast<T>(z)) == FP_SUBNORMAL;
          };
          if (has_fewer_digits(x[k]) || has_fewer_digits(y[k])) continue;
          ASSERT_EQ(y[k], x[k] * units(dimensions[k]))
              << "number " << k << ": " << y[k] / x[k] << " and not L^" << dimensions[k].length << " M^"
              << dimensions[k].mass << " T^" << dimensions[k].time << " of " << row.units;
        }
      }
    });
  });
}

/// A closed mechanism, and the same mechanism in other units.
struct ClosedInUnits {
  ClosedInUnits(const Units& in, std::uint64_t seed)
      : units(in),
        random(seed),
        one(closed_mechanism(random)),
        other(ModelBuilder(in_units(units, one.description)).build()),
        state(in_units(units, one.model, one.state)),
        tau(in_units(units, one.model, Ask{.tau = one.tau}).tau),
        loops(one.model),
        other_loops(other) {}
  /// The accelerations of both mechanisms under their drives and loads, those of the second changed back into
  /// the units of the first.
  std::pair<Numbers, Numbers> accelerations() {
    Numbers a(one.tau.size()), other_a(a.size());
    EXPECT_TRUE(
        forward_dynamics(one.model, loops, one.state.q, one.state.v, one.tau, a, {}, one.state.loads()).ok());
    EXPECT_TRUE(forward_dynamics(other, other_loops, state.q, state.v, tau, other_a, {}, state.loads()).ok());
    const Units back{.length = 1 / units.length, .mass = 1 / units.mass, .time = 1 / units.time};
    return {a, in_units(back, one.model, Ask{.a = other_a}).a};
  }

  Units units;
  Random<double> random;
  ClosedMechanism one;
  Model other;
  State<double> state;
  Numbers tau;
  LoopWorkspace<double> loops, other_loops;
};

/// The rows of loops are couples or forces, and only the unit of length makes a difference between these.
/// Changes of the units of mass and time must therefore multiply results without any rounding.
TEST(UnitsOfLoops, OfMassAndTimeMultiplyToTheLastBit) {
  for (const Units& units :
       {Units{.mass = 0x1p-20}, Units{.mass = 0x1p20}, Units{.time = 0x1p-10}, Units{.time = 0x1p10}})
    for_seeds(60, [&](std::uint64_t seed) {
      ClosedInUnits in(units, seed);
      const auto multiplied = [&](Numbers x, const Dimension& dimension) {
        for (double& x_k : x) x_k *= units(dimension);
        return x;
      };
      const std::size_t m = static_cast<std::size_t>(in.other.loops().rows);
      Numbers gamma(m), other_gamma(m);
      loop_bias(in.one.model, in.loops, in.one.state.q, in.one.state.v, gamma);
      loop_bias(in.other, in.other_loops, in.state.q, in.state.v, other_gamma);
      EXPECT_EQ(other_gamma, multiplied(gamma, dimension::rate * dimension::rate));
      const auto [a, other_a] = in.accelerations();
      EXPECT_EQ(other_a, a);
      Numbers tau(a.size()), other_tau(a.size());
      const double left = inverse_dynamics(in.one.model, in.loops, in.one.state.q, in.one.state.v,
                                           in.one.state.a, tau, {}, {}, in.one.state.loads());
      EXPECT_EQ(inverse_dynamics(in.other, in.other_loops, in.state.q, in.state.v, in.state.a, other_tau, {},
                                 {}, in.state.loads()),
                left);
      EXPECT_EQ(other_tau, multiplied(tau, dimension::mass * dimension::rate * dimension::rate));
      const AssemblyResult closed = assemble(in.one.model, in.one.state.q, in.one.state.v),
                           other_closed = assemble(in.other, in.state.q, in.state.v);
      EXPECT_EQ(other_closed.status, closed.status);
      EXPECT_EQ(other_closed.q, closed.q);
      EXPECT_EQ(other_closed.v, multiplied(closed.v, dimension::rate));
      const LoopMobility mobility = loop_mobility(in.one.model, in.one.state.q),
                         other_mobility = loop_mobility(in.other, in.state.q);
      EXPECT_EQ(other_mobility.rank, mobility.rank);
      EXPECT_EQ(other_mobility.mobility, mobility.mobility);
      EXPECT_EQ(other_mobility.indeterminate, mobility.indeterminate);
    });
}

TEST(UnitsOfLoops, OfLengthChangeNeitherAccelerationsNorMobility) {
  Comparison accelerations("a", 1e-9);
  for (const Units& units : {Units{.length = 0x1p-10}, Units{.length = 0x1p10}})
    for_seeds(60, [&](std::uint64_t seed) {
      ClosedInUnits in(units, seed);
      const auto [a, other_a] = in.accelerations();
      accelerations.expect_equal(other_a, a);
      const LoopMobility mobility = loop_mobility(in.one.model, in.one.state.q),
                         other_mobility = loop_mobility(in.other, in.state.q);
      EXPECT_EQ(other_mobility.rank, mobility.rank);
      EXPECT_EQ(other_mobility.mobility, mobility.mobility);
      EXPECT_EQ(other_mobility.indeterminate, mobility.indeterminate);
    });
}

/// The guess tears the loops.
TEST(UnitsOfLoops, OfLengthDoNotChangeHowLoopsAreClosed) {
  Comparison configurations("q", 1e-9);
  int closed_loops = 0, tried = 0;
  for (const Units& units : {Units{.length = 0x1p-10}, Units{.length = 0x1p10}})
    for_seeds(60, [&](std::uint64_t seed) {
      ClosedInUnits in(units, seed);
      State<double> torn = in.one.state;
      torn.q = integrate(in.one.model, torn.q, random_numbers(in.random, in.one.model.nv(), 0.03));
      const State<double> other_torn = in_units(units, in.one.model, torn);
      const AssemblyResult closed = assemble(in.one.model, torn.q, torn.v),
                           other_closed = assemble(in.other, other_torn.q, other_torn.v);
      EXPECT_EQ(other_closed.status, closed.status);
      ++tried;
      if (closed.status != AssemblyStatus::closed) return;
      ++closed_loops;
      const Units back{.length = 1 / units.length};
      const Numbers q = in_units(back, in.one.model, State<double>{.q = other_closed.q, .v = {}, .a = {}}).q;
      configurations.expect_equal(q, closed.q);
    });
  EXPECT_GT(2 * closed_loops, tried);
}

}  // namespace
}  // namespace axode::test
