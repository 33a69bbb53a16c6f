#include <memory>
#include <numbers>
#include <sstream>

#include "axode/codegen.hpp"
#include "axode/codegen/c/c_function.hpp"
#include "axode/codegen/c/c_sine_cosine.hpp"
#include "axode/io.hpp"
#include "tests/codegen/compiled.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/functions.hpp"
#include "tests/support/refused_arguments.hpp"

/// Generated functions give the same results as the library.
namespace axode::test {
namespace {

using catalog::Id;
using codegen::Function;

class GeneratedCode : public Law {};
INSTANTIATE_TEST_SUITE_P(Codegen, GeneratedCode, testing::ValuesIn(scalars()), name_of);

/// The results of a generated function and its return value.
struct Result {
  std::vector<double> numbers;
  int status = 0;
};
/// Calls name(arguments..., out) with memory for `size` results.
template <class T, class Returned = void>
Result call_in(const Compiled& library, const std::string& name,
               const std::vector<std::vector<double>>& arguments, std::size_t size) {
  std::vector<std::vector<T>> x;
  for (const std::vector<double>& argument : arguments) x.push_back(cast<T>(argument));
  std::vector<T> out(size);
  int status = 0;
  const auto call = [&](auto... pointers) {
    Returned (*function)(decltype(pointers)..., T*) =
        library.function<Returned(decltype(pointers)..., T*)>(name);
    if constexpr (std::same_as<Returned, int>)
      status = function(pointers..., out.data());
    else
      function(pointers..., out.data());
  };
  const auto pointer = [&](std::size_t k) { return static_cast<const T*>(x.at(k).data()); };
  switch (x.size()) {
    case 1: call(pointer(0)); break;
    case 3: call(pointer(0), pointer(1), pointer(2)); break;
    case 4: call(pointer(0), pointer(1), pointer(2), pointer(3)); break;
    default: call(pointer(0), pointer(1), pointer(2), pointer(3), pointer(4), pointer(5)); break;
  }
  return {cast<double>(out), status};
}
/// Calls a function in the scalar type of a case.
std::vector<double> called(const Case& c, const Compiled& library, const std::string& name,
                           const std::vector<std::vector<double>>& arguments, std::size_t size) {
  return (c.single ? call_in<float> : call_in<double>)(library, name, arguments, size).numbers;
}
Result solved(const Case& c, const Compiled& library, const std::string& name,
              const std::vector<std::vector<double>>& arguments, std::size_t size) {
  return (c.single ? call_in<float, int> : call_in<double, int>)(library, name, arguments, size);
}

/// The generated functions of one model; the functions of several models are compiled together.
struct Generated {
  Trial trial;
  Random<double> random;
  Function jacobian;
  codegen::Source source;

  Generated(const Case& c, std::uint64_t seed)
      : trial(c, seed, TreeRecipe{.most_bodies = 25, .springs = 0}),
        random(seed + 1000),
        jacobian{Id("jacobian")} {
    jacobian.frame = static_cast<int>(random.number(0, trial.model.n_frames()));
    jacobian.representation = static_cast<Representation>(seed % 4);
    const std::vector<Function> functions{
        {Id("inverse_dynamics")}, {Id("forward_dynamics")}, {Id("mass_matrix")}, jacobian};
    source = codegen::c_source(trial.model, functions, {"tree" + std::to_string(seed), c.single});
  }
  const std::string& name(std::size_t k) const { return source.functions[k].name; }
};

/// The Jacobian that the library computes, row by row.
std::vector<double> library_jacobian(const Trial& trial, const Function& wanted, const Ask& at) {
  Trial in_wanted = trial.by(wanted.representation);
  Ask ask = at;
  ask.place = wanted.frame;
  const std::vector<double> columns = in_wanted.call("jacobian", ask);
  const std::size_t nv = columns.size() / 6;
  std::vector<double> rows(columns.size());
  for (std::size_t c = 0; c < nv; ++c)
    for (std::size_t r = 0; r < 6; ++r) rows[r * nv + c] = columns[6 * c + r];
  return rows;
}

TEST_P(GeneratedCode, GivesWhatTheLibraryGives) {
  const Case fastest = fast(GetParam());
  const double agreement = fastest.agreement();
  Comparison force("force", agreement), inertia("mass matrix", agreement), columns("Jacobian", agreement);
  int singular = 0, solvable = 0, doubted = 0, coupled = 0;
  const int models = fastest.single ? 20 : 40;  // in float the statements are the same
  constexpr int in_a_file = 10;
  for (int first = 1; first <= models && !testing::Test::HasFailure(); first += in_a_file) {
    std::vector<std::unique_ptr<Generated>> group;
    std::string text;
    for (int seed = first; seed < first + in_a_file; ++seed) {
      group.push_back(std::make_unique<Generated>(fastest, static_cast<std::uint64_t>(seed)));
      text += group.back()->source.text;
    }
    const Compiled library(text);
    for (std::size_t k = 0; k < group.size(); ++k) {
      SCOPED_TRACE("seed " + std::to_string(first + static_cast<int>(k)));
      Generated& generated = *group[k];
      Trial& trial = generated.trial;
      const Model& model = trial.model;
      const std::size_t nv = static_cast<std::size_t>(model.nv());
      coupled += model.n_screws() > model.nv();
      for (int s = 0; s < 4; ++s) {
        const State<double> state = rounded(fastest, random_state(model, generated.random));
        Ask ask{.q = state.q, .v = state.v, .a = state.a};
        ask.tau = trial.call("inverse_dynamics", ask);
        force.expect_equal(called(fastest, library, generated.name(0), {ask.q, ask.v, ask.a}, nv), ask.tau);

        const auto [found, doubt] = solved(fastest, library, generated.name(1), {ask.q, ask.v, ask.tau}, nv);
        const bool ok = trial.answer("forward_dynamics", ask).solvability.ok();
        EXPECT_TRUE(ok || doubt == 1) << "a singular mass matrix is told";
        singular += !ok, doubted += ok && doubt == 1;
        if (doubt ==
            0) {  // M may be ill-conditioned, so that accelerations are compared by the forces that they need
          ++solvable;
          force.expect_equal(trial.call("inverse_dynamics", {.q = ask.q, .v = ask.v, .a = found}), ask.tau);
        }

        inertia.expect_equal(called(fastest, library, generated.name(2), {ask.q}, nv * nv),
                             trial.call("mass_matrix", ask));
        columns.expect_equal(called(fastest, library, generated.name(3), {ask.q}, 6 * nv),
                             library_jacobian(trial, generated.jacobian, ask));
      }
    }
  }
  EXPECT_GE(singular, models / 6);
  EXPECT_GE(solvable, models * 5 / 3);
  EXPECT_GE(coupled, models / 12);
  EXPECT_LE(doubted, solvable / 20) << "doubt is rare where the library finds accelerations";
}

/// The models have few bodies, because the derivatives of forward dynamics are long programs.
TEST_P(GeneratedCode, HasTheDerivativesThatTheLibraryHas) {
  const Case fastest = fast(GetParam());
  Comparison inverse("inverse", fastest.agreement()), forward("forward", fastest.agreement());
  constexpr Id quantities[]{Id("inverse_dynamics_derivatives"), Id("inverse_dynamics_jvp"),
                            Id("inverse_dynamics_vjp"),         Id("forward_dynamics_derivatives"),
                            Id("forward_dynamics_jvp"),         Id("forward_dynamics_vjp"),
                            Id("inverse_dynamics_hessian"),     Id("forward_dynamics_hessian")};
  std::vector<Function> functions;
  for (const Id quantity : quantities) functions.push_back({quantity});
  int solvable = 0;
  std::string text;
  std::vector<std::unique_ptr<Trial>> trials;
  std::vector<codegen::Source> sources;
  for (std::uint64_t seed = 1; seed <= (fastest.single ? 4 : 8); ++seed) {
    trials.emplace_back(new Trial(fastest, seed, {.most_bodies = 6, .springs = 0}));
    sources.push_back(
        codegen::c_source(trials.back()->model, functions, {"tree" + std::to_string(seed), fastest.single}));
    text += sources.back().text;
  }
  const Compiled library(text);
  for (std::size_t k = 0; k < trials.size(); ++k) {
    SCOPED_TRACE("seed " + std::to_string(k + 1));
    Trial& trial = *trials[k];
    const std::size_t nv = static_cast<std::size_t>(trial.model.nv());
    Random<double> random(k + 1000);
    for (int s = 0; s < 4; ++s) {
      const State<double> state = rounded(fastest, random_state(trial.model, random));
      Ask ask{.q = state.q, .v = state.v, .a = state.a};
      for (auto* const x : {&ask.dq, &ask.dv, &ask.da, &ask.w})
        *x = cast<double>(cast<float>(random_numbers(random, trial.model.nv())));
      ask.tau = cast<double>(cast<float>(trial.call("inverse_dynamics", ask)));
      ask.dtau = ask.da;
      const auto name = [&](std::size_t f) { return sources[k].functions[f].name; };
      const auto dtau = trial.call("inverse_dynamics_derivatives", ask);
      const double scale = std::max(largest(dtau), 1e-6);
      inverse.expect_equal(called(fastest, library, name(0), {ask.q, ask.v, ask.a}, 3 * nv * nv), dtau,
                           scale);
      inverse.expect_equal(
          called(fastest, library, name(1), {ask.q, ask.v, ask.a, ask.dq, ask.dv, ask.da}, nv),
          trial.call("inverse_dynamics_jvp", ask), scale);
      inverse.expect_equal(called(fastest, library, name(2), {ask.q, ask.v, ask.a, ask.w}, 3 * nv),
                           trial.call("inverse_dynamics_vjp", ask), scale);
      const auto hessian = trial.call("inverse_dynamics_hessian", ask);
      inverse.expect_equal(called(fastest, library, name(6), {ask.q, ask.v, ask.a, ask.w}, 4 * nv * nv),
                           hessian, scale);
      const auto [da, doubt] = solved(fastest, library, name(3), {ask.q, ask.v, ask.tau}, 3 * nv * nv);
      if (doubt != 0 || fastest.single) continue;  // M may be too ill-conditioned to compare in float
      ++solvable;
      const auto expected = trial.call("forward_dynamics_derivatives", ask);
      const auto M = matrix(trial.model.nv(), trial.call("mass_matrix", ask));
      const auto forces_of = [&](const std::vector<double>& all, std::size_t from, Eigen::Index columns) {
        return Eigen::MatrixXd(M * Eigen::Map<const Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(
                                       all.data() + from, trial.model.nv(), columns));
      };
      for (const std::size_t part : {0, 1, 2})
        forward.expect_equal(forces_of(da, part * nv * nv, trial.model.nv()),
                             forces_of(expected, part * nv * nv, trial.model.nv()), scale);
      forward.expect_equal(
          forces_of(solved(fastest, library, name(4), {ask.q, ask.v, ask.tau, ask.dq, ask.dv, ask.dtau}, nv)
                        .numbers,
                    0, 1),
          forces_of(trial.call("forward_dynamics_jvp", ask), 0, 1), scale);
      const auto gradient = solved(fastest, library, name(5), {ask.q, ask.v, ask.tau, ask.w}, 3 * nv).numbers;
      const Eigen::VectorXd w = vector(ask.w);
      for (std::size_t part : {0, 1, 2}) {
        const Eigen::MatrixXd D = Eigen::Map<const Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(
            expected.data() + part * nv * nv, trial.model.nv(), trial.model.nv());
        forward.expect_equal(
            Eigen::VectorXd(vector(gradient).segment(static_cast<Eigen::Index>(part * nv), trial.model.nv())),
            Eigen::VectorXd(D.transpose() * w), 1e3 * std::max(largest(expected), 1e-6));
      }
      const auto curved = trial.call("forward_dynamics_hessian", ask);
      forward.expect_equal(
          solved(fastest, library, name(7), {ask.q, ask.v, ask.tau, ask.w}, 4 * nv * nv).numbers, curved,
          1e3 * largest(curved));
    }
  }
  EXPECT_TRUE(fastest.single || solvable >= 20);
}

/// The output of a compiler for C source.
std::string complaints(const std::string& source, std::vector<std::string> words) {
  const TemporaryFolder folder;
  const std::string file = folder.write("generated.c", source);
  words.insert(words.begin(), AXODE_COMPILER);
  words.insert(words.end(), {"-Wall", "-Wextra", "-pedantic", "-Werror", "-fsyntax-only", file});
  return run(words).err;
}

TEST_P(GeneratedCode, CompilesWithoutWarningsAsC99AndAsCpp) {
  const std::vector<Function> functions{{Id("inverse_dynamics")},
                                        {Id("forward_dynamics")},
                                        {Id("mass_matrix")},
                                        {Id("jacobian"), 0},
                                        {Id("jacobian"), 2, Representation::mixed},
                                        {Id("inverse_dynamics_vjp")},
                                        {Id("forward_dynamics_jvp")},
                                        {Id("inverse_dynamics_hessian")}};
  for (const auto& [file, base] :
       {std::pair("arm7.toml", Base::fixed), std::pair("machine.toml", Base::as_described),
        std::pair("humanoid.urdf", Base::free)}) {
    const codegen::Source source = codegen::c_source(
        load(robot(file), base), functions, {.prefix = "robot", .single_precision = GetParam().single});
    EXPECT_EQ(complaints(source.text, {"-x", "c", "-std=c99"}), "") << file;
    EXPECT_EQ(complaints(source.text, {"-x", "c++"}), "") << file;
    EXPECT_NE(complaints(source.text, {"-x", "c", "-std=c99", "-ffast-math"}), "") << file;
  }
}

/// Three hinges whose axes z, y and z go through one point. Only the last one moves a mass. If the first and
/// the last axis coincide, the mass matrix is singular.
Model wrist(double mass = 1) {
  const auto hinge = [](const char* name, const char* on, const Vec3<>& axis) {
    return BodyDescription{
        .name = name, .predecessor = on, .joint = {.kind = JointKind::revolute, .axis = axis}};
  };
  BodyDescription last = hinge("c", "b", {0, 0, 1});
  if (mass > 0) last.inertia = MassProperties{.mass = mass, .Theta = {0.1, 0.2, 0.25, 0, 0, 0}};
  return ModelBuilder("wrist")
      .add(hinge("a", "ground", {0, 0, 1}))
      .add(hinge("b", "a", {0, 1, 0}))
      .add(last)
      .build();
}

TEST_P(GeneratedCode, TellsWhereTheMassMatrixIsSingular) {
  const std::vector<Function> functions{{Id("forward_dynamics")}};
  const bool single = GetParam().single;
  const Compiled library(codegen::c_source(wrist(), functions, {"wrist", single}).text);
  const Compiled massless(codegen::c_source(wrist(0), functions, {"wrist", single}).text);
  const std::vector<double> straight{0.3, 0, 0.2}, bent{0.3, 1, 0.2}, zero{0, 0, 0};
  const auto status = [&](const Compiled& of, const std::vector<double>& q) {
    return solved(GetParam(), of, "wrist_forward_dynamics", {q, zero, zero}, 3).status;
  };
  EXPECT_EQ(status(library, bent), 0);
  EXPECT_EQ(status(library, straight), 1);
  EXPECT_EQ(status(massless, bent), 1);
}

/// The distance of x from a number, in units of the last place.
template <class T> double units(T x, double exact) {
  const T nearest = static_cast<T>(exact);
  const double unit = std::abs(static_cast<double>(std::nextafter(nearest, T(2)) - nearest));
  return std::abs(static_cast<double>(x) - exact) / unit;
}

/// The end of a crank of 1 m moves with velocity components -sin q and cos q, so that its Jacobian shows the
/// errors of both functions.
TEST_P(GeneratedCode, HasSinesAndCosinesOfTwoUnitsInTheLastPlace) {
  const Model crank = ModelBuilder("crank")
                          .add({.name = "crank", .joint = {.kind = JointKind::revolute, .axis = {0, 0, 1}}})
                          .add(FrameDescription{.name = "pin", .body = "crank", .pose = {{}, {1, 0, 0}}})
                          .build();
  const std::vector<Function> functions{{Id("jacobian"), crank.frame_index("pin"), Representation::hybrid}};
  const Compiled library(codegen::c_source(crank, functions, {"crank", GetParam().single}).text);
  with_scalar(GetParam(), [&](auto scalar) {
    using T = decltype(scalar);
    const auto function = library.function<void(const T*, T*)>("crank_jacobian_pin_hybrid");
    Random<double> random(1);
    for (int trial = 0; trial < 200000 && !testing::Test::HasFailure(); ++trial) {
      const double size = std::pow(10.0, random.number(-6, 5));
      const double anywhere = random.number(-size, size);
      const double quarter_turns = std::round(random.number(-6e4, 6e4)) * std::numbers::pi / 2;
      const T q = static_cast<T>(trial % 2 == 0 ? anywhere : quarter_turns);
      T J[6];
      function(&q, J);
      EXPECT_LE(units(-J[3], std::sin(static_cast<double>(q))), 2) << q;
      EXPECT_LE(units(J[4], std::cos(static_cast<double>(q))), 2) << q;
    }
  });
}

/// Expressions with every operation that a tape can hold, and sines of sines.
template <class N> std::vector<N> every_operation(N x, N y, N z) {
  const N a = sin(x) * cos(y) + z / (N(2) + x * x), b = sqrt(N(1) + a * a) - N(3) * y,
          c = atan2(b, sin(a) - y);
  const auto less = [](const N& u, const N& v) { return !(v <= u); };
  return {a, -b, N(0.1) * c, N(7), x, select(x < y && y <= z, a, b), select(less(z, a) || y < x, a, -a)};
}

TEST_P(GeneratedCode, ComputesWhatIsRecorded) {
  codegen::Recording recording{.arguments = {"q"}, .result = "f"};
  {
    Tape tape;
    recording.results = every_operation(tape.input(0, 0), tape.input(0, 1), tape.input(0, 2));
    recording.nodes = tape.nodes();
  }
  EXPECT_TRUE(codegen::calls_math_library(recording));
  const codegen::Precision precision{GetParam().single};
  const Compiled library("#include <math.h>\n#define AXODE_RESTRICT restrict\n" +
                         codegen::c_sine_cosine("turn", precision, codegen::Angles::moderate) +
                         codegen::c_definition(recording, "f_of_q", "turn", precision).text);
  Comparison value("value", GetParam().single ? 1e-5 : 1e-14);
  Random<double> random(7);
  for (int trial = 0; trial < 1000; ++trial) {
    const auto number = [&] {
      const double x = random.number(-1, 1);
      return GetParam().single ? static_cast<double>(static_cast<float>(x)) : x;
    };
    const std::vector<double> q{number(), number(), number()};
    value.expect_equal(called(GetParam(), library, "f_of_q", {q}, 7), every_operation(q[0], q[1], q[2]));
  }
}

/// The fast path takes 150 multiplications and additions for a hinge. An arm with axes at right angles needs
/// about a third of these.
TEST(GeneratedOperations, AreOnlyThoseThatTheMechanismNeeds) {
  const std::vector<Function> functions{{Id("inverse_dynamics")}, {Id("mass_matrix")}};
  const codegen::Source arm = codegen::c_source(load(robot("arm7.toml")), functions);
  const Operations &forces = arm.functions[0].operations, &matrix = arm.functions[1].operations;
  EXPECT_LE(forces.products + forces.sums, 7 * 54);
  EXPECT_EQ(forces.angles, 12) << "gravity is along the first axis";
  EXPECT_EQ(matrix.angles, 10) << "M depends neither on the first angle nor on the last";
  EXPECT_EQ(forces.divisions + matrix.divisions, 0);
}

/// Long functions are divided into parts, because the time that compilers take for a statement grows with the
/// length of its function.
TEST(GeneratedParts, AreShort) {
  const Model model = load(robot("humanoid.urdf"), Base::free);
  const Function function{Id("inverse_dynamics_derivatives")};
  std::istringstream source(codegen::c_source(model, {&function, 1}).text);
  int parts = 0, statements = 0, all = 0;
  for (std::string line; std::getline(source, line);) {
    if (line.starts_with("static AXODE_PART")) ++parts, statements = 0;
    if (!line.starts_with("  const double t")) continue;
    ++all;
    ASSERT_LE(++statements, 500);
  }
  EXPECT_GT(all, 10'000);
  EXPECT_LT(parts, all / 250);
}

TEST(GeneratedNames, AreIdentifiersAndNoTwoAreTheSame) {
  ModelBuilder builder("7 of 9");
  builder.add({.name = "link */ 1", .joint = {.kind = JointKind::revolute, .axis = {0, 0, 1}}});
  for (const char* name : {"tool 1", "tool_1", "tool-1", "tool_1_2"})
    builder.add(FrameDescription{.name = name, .body = "link */ 1"});
  const Model model = builder.build();
  std::vector<Function> functions;
  for (int f = 0; f < model.n_frames(); ++f) functions.push_back({Id("jacobian"), f});
  const codegen::Source source = codegen::c_source(model, functions);
  std::vector<std::string> names;
  for (const auto& function : source.functions) names.push_back(function.name);
  EXPECT_THAT(names,
              testing::ElementsAre("model_7_of_9_jacobian_ground", "model_7_of_9_jacobian_link____1",
                                   "model_7_of_9_jacobian_tool_1", "model_7_of_9_jacobian_tool_1_2",
                                   "model_7_of_9_jacobian_tool_1_3", "model_7_of_9_jacobian_tool_1_2_2"));
  EXPECT_EQ(complaints(source.text, {"-x", "c", "-std=c99"}), "");
}

TEST(GeneratedCodeArguments, AreChecked) {
  const Model model = wrist();
  const auto call = [&](const std::vector<Function>& functions, const std::string& prefix = "") {
    return message_of([&] { codegen::c_source(model, functions, {.prefix = prefix}); });
  };
  EXPECT_EQ(call({}), "functions is empty; expected at least one to generate code for");
  EXPECT_EQ(call({{Id("mass_matrix")}}, "7th"),
            "the prefix \"7th\" is not a C identifier: letters, digits and underscores, no digit first");
  EXPECT_EQ(call({{Id("jacobian"), 9}}), "frame is 9; model \"wrist\" has frames 0 to 3");
  EXPECT_EQ(call({{Id("mass_matrix")}, {Id("mass_matrix")}}), "wrist_mass_matrix is asked for twice");
}

}  // namespace
}  // namespace axode::test
