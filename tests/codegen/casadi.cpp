#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "axode/codegen.hpp"
#include "axode/io.hpp"
#include "tests/codegen/compiled.hpp"
#include "tests/support/refused_arguments.hpp"
#include "tests/support/run_program.hpp"

/// Functions for CasADi, called as CasADi calls them.
namespace axode::test {
namespace {

using catalog::Id;
using codegen::Function;
using Numbers = std::vector<double>;

Model machine() { return load(robot("machine.toml"), Base::as_described); }

codegen::Source source_for_casadi(const Model& model, const std::vector<Function>& functions,
                                  int states = 1) {
  return codegen::c_source(model, functions, {.prefix = "m", .abi = codegen::Abi::casadi, .states = states});
}

/// A function of a library, and what it says of itself.
class External {
 public:
  External(const Compiled& library, const std::string& name) : library_(library), name_(name) {}
  long long n_in() const { return library_.function<long long()>(name_ + "_n_in")(); }
  long long n_out() const { return library_.function<long long()>(name_ + "_n_out")(); }
  std::string name_in(int i) const {
    return library_.function<const char*(long long)>(name_ + "_name_in")(i);
  }
  std::string name_out(int i) const {
    return library_.function<const char*(long long)>(name_ + "_name_out")(i);
  }
  /// Rows and columns, and the row and column of each entry.
  struct Pattern {
    long long rows, columns;
    std::vector<std::pair<long long, long long>> entries;
  };
  Pattern in(int i) const { return pattern("_sparsity_in", i); }
  Pattern out(int i) const { return pattern("_sparsity_out", i); }

  /// Entries of all results; arguments without entries are null.
  std::vector<Numbers> operator()(const std::vector<Numbers>& arguments) const {
    long long sizes[4];
    library_.function<int(long long*, long long*, long long*, long long*)>(name_ + "_work")(
        &sizes[0], &sizes[1], &sizes[2], &sizes[3]);
    std::vector<const double*> arg;
    for (const Numbers& x : arguments) arg.push_back(x.empty() ? nullptr : x.data());
    arg.resize(static_cast<std::size_t>(n_in()), nullptr);
    std::vector<Numbers> results;
    std::vector<double*> res;
    for (int i = 0; i < n_out(); ++i) results.emplace_back(out(i).entries.size(), std::nan(""));
    for (Numbers& x : results) res.push_back(x.data());
    Numbers w(static_cast<std::size_t>(sizes[3]));
    status_ = library_.function<int(const double**, double**, long long*, double*, int)>(name_)(
        arg.data(), res.data(), nullptr, w.data(), 0);
    return results;
  }
  int status() const { return status_; }

 private:
  Pattern pattern(const char* which, int i) const {
    const long long* p = library_.function<const long long*(long long)>(name_ + which)(i);
    Pattern found{p[0], p[1], {}};
    const bool dense = p[2] == 1;
    const long long* begin = p + 2;
    const long long* row = begin + p[1] + 1;
    for (long long c = 0; c < p[1]; ++c)
      for (long long k = dense ? 0 : begin[c]; k < (dense ? p[0] : begin[c + 1]); ++k)
        found.entries.emplace_back(dense ? k : row[k], c);
    return found;
  }

  const Compiled& library_;
  std::string name_;
  mutable int status_ = 0;
};

/// Random arguments of a function of the state: a configuration, whose quaternions are too long, and whatever.
std::vector<Numbers> random_arguments(const External& f, std::mt19937& random) {
  std::uniform_real_distribution<> between(-1, 1);
  std::vector<Numbers> x;
  for (int i = 0; i < f.n_in(); ++i) {
    x.emplace_back(f.in(i).entries.size());
    for (double& entry : x.back()) entry = between(random);
  }
  return x;
}

/// What a step of entry k of argument i does to all results of f, by a step.
std::vector<Numbers> difference(const External& f, std::vector<Numbers> x, std::size_t i, std::size_t k) {
  constexpr double step = 1e-5;
  double& entry = x[i][k];
  const double at = entry;
  entry = at + step;
  std::vector<Numbers> high = f(x);
  entry = at - step;
  const std::vector<Numbers> low = f(x);
  for (std::size_t o = 0; o < high.size(); ++o)
    for (std::size_t r = 0; r < high[o].size(); ++r) high[o][r] = (high[o][r] - low[o][r]) / (2 * step);
  return high;
}

/// Blocks `jac` of the first `inputs` arguments are the derivatives of the results of f.
void expect_derivatives(const External& f, const External& jac, const std::vector<Numbers>& x,
                        std::size_t inputs) {
  const std::vector<Numbers> blocks = jac(x), value = f(x);
  const std::size_t all_inputs = blocks.size() / static_cast<std::size_t>(f.n_out());
  for (std::size_t o = 0; o < static_cast<std::size_t>(f.n_out()); ++o)
    for (std::size_t i = 0; i < inputs; ++i) {
      const External::Pattern block = jac.out(static_cast<int>(o * all_inputs + i)),
                              out = f.out(static_cast<int>(o));
      EXPECT_EQ(block.rows, out.rows * out.columns);
      const External::Pattern in = f.in(static_cast<int>(i));
      for (std::size_t k = 0; k < x[i].size(); ++k) {
        const long long column = in.entries[k].first + in.rows * in.entries[k].second;
        Numbers expected(static_cast<std::size_t>(block.rows)), found = expected;
        const Numbers change = difference(f, x, i, k)[o];
        double size = 1;  // differences of large numbers are not exact
        for (const double y : value[o]) size = std::max(size, std::abs(y));
        for (std::size_t r = 0; r < change.size(); ++r) {
          expected[static_cast<std::size_t>(out.entries[r].first + out.rows * out.entries[r].second)] =
              change[r];
          size = std::max(size, std::abs(change[r]));
        }
        for (std::size_t r = 0; r < block.entries.size(); ++r)
          if (block.entries[r].second == column)
            found[static_cast<std::size_t>(block.entries[r].first)] = blocks[o * all_inputs + i][r];
        for (std::size_t r = 0; r < expected.size(); ++r)
          ASSERT_NEAR(found[r], expected[r], 1e-5 * size)
              << f.name_out(static_cast<int>(o)) << " by " << f.name_in(static_cast<int>(i));
      }
    }
}

const std::vector<Function> all{{Id("forward_dynamics")},
                                {Id("inverse_dynamics")},
                                {Id("mass_matrix")},
                                {Id("inverse_mass_matrix")},
                                {Id("poses")},
                                {Id("pose"), 9},
                                {Id("jacobian"), 9, Representation::mixed}};

TEST(FunctionsForCasadi, HaveFirstAndSecondDerivativesByEveryCoordinate) {
  const codegen::Source source = source_for_casadi(machine(), all);
  const Compiled library(source.text);
  ASSERT_EQ(source.functions.size(),
            5 * all.size() - 1);  // the inverse mass matrix has no second derivatives
  std::mt19937 random(1);
  for (std::size_t k = 0; k < source.functions.size();) {
    const std::string& name = source.functions[k].name;
    const bool has_second = name != "m_inverse_mass_matrix";
    k += has_second ? 5 : 4;
    SCOPED_TRACE(name);
    const External f(library, name), gradient(library, "adj1_" + name);
    const std::size_t inputs = static_cast<std::size_t>(f.n_in());
    expect_derivatives(f, External(library, "jac_" + name), random_arguments(f, random), inputs);
    if (has_second)
      expect_derivatives(gradient, External(library, "jac_adj1_" + name), random_arguments(gradient, random),
                         static_cast<std::size_t>(gradient.n_in()));
    const External tangent(library, "fwd1_" + name);
    std::vector<Numbers> x = random_arguments(tangent, random), at(x.begin(), x.begin() + f.n_in());
    for (Numbers& direction : x) direction = {};
    std::ranges::copy(at, x.begin());
    x.back() = Numbers(at.back().size());
    x.back()[0] = 1;
    const std::vector<Numbers> change = tangent(x), expected = difference(f, at, inputs - 1, 0),
                               value = f(at);
    for (std::size_t o = 0; o < change.size(); ++o)
      for (std::size_t r = 0; r < change[o].size(); ++r)
        EXPECT_NEAR(change[o][r], expected[o][r],
                    1e-5 * (1 + std::abs(value[o][r]) + std::abs(expected[o][r])));
  }
}

TEST(FunctionsForCasadi, OfSeveralStatesAreThoseOfEachSideBySide) {
  const Model model = machine();
  const Compiled one(source_for_casadi(model, {{Id("forward_dynamics")}}).text),
      three(source_for_casadi(model, {{Id("forward_dynamics")}}, 3).text);
  std::mt19937 random(2);
  for (const std::string name :
       {"m_forward_dynamics", "jac_m_forward_dynamics", "jac_adj1_m_forward_dynamics"}) {
    const External f(one, name), g(three, name);
    std::vector<Numbers> all_x(static_cast<std::size_t>(f.n_in())),
        expected(static_cast<std::size_t>(f.n_out()));
    for (int state = 0; state < 3; ++state) {
      const std::vector<Numbers> x = random_arguments(f, random), y = f(x);
      for (std::size_t i = 0; i < x.size(); ++i) all_x[i].insert(all_x[i].end(), x[i].begin(), x[i].end());
      for (std::size_t o = 0; o < y.size(); ++o)
        expected[o].insert(expected[o].end(), y[o].begin(), y[o].end());
    }
    EXPECT_EQ(g(all_x), expected);
    for (int o = 0; o < f.n_out(); ++o) {
      const bool diagonal = name.starts_with("jac_");
      EXPECT_EQ(g.out(o).rows, (diagonal ? 3 : 1) * f.out(o).rows);
      EXPECT_EQ(g.out(o).columns, 3 * f.out(o).columns);
      ASSERT_EQ(g.out(o).entries.size(), 3 * f.out(o).entries.size());
      for (std::size_t k = 0; k < f.out(o).entries.size(); ++k) {
        const auto [row, column] = g.out(o).entries[k + 2 * f.out(o).entries.size()];
        EXPECT_EQ(row, f.out(o).entries[k].first + (diagonal ? 2 * f.out(o).rows : 0));
        EXPECT_EQ(column, f.out(o).entries[k].second + 2 * f.out(o).columns);
      }
    }
  }
}

TEST(FunctionsForCasadi, TakeNothingForZeroAndTellWhatIsSingular) {
  const Model model = machine();
  const Compiled library(
      source_for_casadi(model, {{Id("forward_dynamics")}, {Id("inverse_mass_matrix")}}).text);
  const External f(library, "m_forward_dynamics");
  const Numbers q = neutral(model), zero(static_cast<std::size_t>(model.nv()));
  EXPECT_EQ(f({q})[0], f({q, zero, zero})[0]);
  EXPECT_EQ(f.status(), 0);
  f({Numbers(q.size(), std::nan(""))});
  EXPECT_EQ(f.status(), 1);
  for (const std::string derivative : {"", "fwd1_", "adj1_", "jac_"}) {
    const External A(library, derivative + "m_inverse_mass_matrix");
    A({q});
    EXPECT_EQ(A.status(), 0);
    A({Numbers(q.size(), std::nan(""))});
    EXPECT_EQ(A.status(), 1) << derivative;
  }
}

TEST(FunctionsForCasadi, CompileWithoutWarningsAsC99AndAsCpp) {
  const TemporaryFolder folder;
  for (const auto& [robot_file, base] :
       {std::pair("machine.toml", Base::as_described), std::pair("arm7.toml", Base::fixed)}) {
    const std::string file =
        folder.write("generated.c", source_for_casadi(load(robot(robot_file), base), all, 2).text);
    for (const std::vector<std::string>& language :
         {std::vector<std::string>{"-x", "c", "-std=c99"}, {"-x", "c++"}}) {
      std::vector<std::string> words{AXODE_COMPILER, "-Wall",   "-Wextra",
                                     "-pedantic",    "-Werror", "-fsyntax-only"};
      words.insert(words.end(), language.begin(), language.end());
      words.push_back(file);
      EXPECT_EQ(run(words).err, "") << robot_file;
    }
  }
}

TEST(FunctionsForCasadi, RefuseWhatTheyCannotBe) {
  const Model model = machine();
  const auto refusal = [&](Id quantity, const codegen::Options& options) {
    return message_of([&] { codegen::c_source(model, std::vector<Function>{{quantity}}, options); });
  };
  constexpr auto casadi = codegen::Abi::casadi;
  EXPECT_EQ(refusal(Id("forward_dynamics_vjp"), {.abi = casadi}),
            "forward_dynamics_vjp comes with forward_dynamics for CasADi, as jac_, fwd1_, adj1_ and "
            "jac_adj1_; ask for that");
  EXPECT_EQ(refusal(Id("mass_matrix"), {.single_precision = true, .abi = casadi}),
            "CasADi computes with double; there is no single precision");
  EXPECT_EQ(refusal(Id("mass_matrix"), {.prefix = "a__b", .abi = casadi}),
            "the prefix \"a__b\" is no name in CasADi: underscores are single there, and between letters or "
            "digits");
  EXPECT_EQ(refusal(Id("mass_matrix"), {.abi = casadi, .states = 0}), "states is 0; expected 1 or more");
  const std::string too_many = refusal(Id("mass_matrix"), {.abi = casadi, .states = 2'000'000'000});
  EXPECT_TRUE(too_many.starts_with("states is 2000000000; ") &&
              too_many.ends_with(" has more than 2147483647 entries of so many"))
      << too_many;
  EXPECT_EQ(refusal(Id("mass_matrix"), {.states = 2}),
            "states is about functions for CasADi; others are of one state");
}

}  // namespace
}  // namespace axode::test
