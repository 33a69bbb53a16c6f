#include <memory>
#include <numbers>

#include "axode/codegen.hpp"
#include "axode/codegen/c_function.hpp"
#include "axode/io.hpp"
#include "tests/codegen/compiled.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/refused_arguments.hpp"

/// Generated functions give what the library gives.
namespace axode::test {
namespace {

using codegen::Function;
using codegen::Quantity;

template <class T> class GeneratedCode : public testing::Test {};
using Scalars = testing::Types<double, float>;
TYPED_TEST_SUITE(GeneratedCode, Scalars);

/// The generated functions of one model. Those of several models are compiled together.
template <class T> struct Generated {
  using OfState = void(const T*, const T*, const T*, T*);
  using Solve = int(const T*, const T*, const T*, T*);
  using OfConfiguration = void(const T*, T*);

  Trial<T> trial;
  Random<double> random;
  Function jacobian;
  codegen::Source source;

  explicit Generated(std::uint64_t seed)
      : trial(Random<double>(seed), TreeRecipe{.most_bodies = 25}),
        random(seed + 1000),
        jacobian{Quantity::jacobian} {
    jacobian.frame = static_cast<int>(random.number(0, trial.model.n_frames()));
    jacobian.representation = static_cast<Representation>(seed % 4);
    const std::vector<Function> functions{
        {Quantity::inverse_dynamics}, {Quantity::forward_dynamics}, {Quantity::mass_matrix}, jacobian};
    source =
        codegen::c_source(trial.model, functions, {"tree" + std::to_string(seed), std::same_as<T, float>});
  }
  template <class Signature> Signature* function(const Compiled& library, std::size_t k) const {
    return library.function<Signature>(source.functions[k].name);
  }
};

template <class T>
std::vector<T> library_jacobian(Trial<T>& trial, const Function& wanted, const std::vector<T>& q) {
  const std::size_t nv = static_cast<std::size_t>(trial.model.nv());
  std::vector<T> rows(6 * nv);
  with_representation(wanted.representation, [&](auto rep) {
    using Rep = decltype(rep);
    std::vector<Twist<Rep, T>> J(nv);
    jacobian<Rep>(trial.model, trial.workspace, q, wanted.frame, J);
    for (std::size_t c = 0; c < nv; ++c) {
      const T column[]{J[c].w.x, J[c].w.y, J[c].w.z, J[c].v.x, J[c].v.y, J[c].v.z};
      for (std::size_t r = 0; r < 6; ++r) rows[r * nv + c] = column[r];
    }
  });
  return rows;
}

TYPED_TEST(GeneratedCode, GivesWhatTheLibraryGives) {
  using T = TypeParam;
  using G = Generated<T>;
  Comparison force("force", agreement<T>), inertia("mass matrix", agreement<T>),
      columns("Jacobian", agreement<T>);
  int singular = 0, solved = 0, doubted = 0, coupled = 0;
  constexpr int models = 60, in_a_file = 10;
  for (int first = 1; first <= models && !testing::Test::HasFailure(); first += in_a_file) {
    std::vector<std::unique_ptr<G>> group;
    std::string text;
    for (int seed = first; seed < first + in_a_file; ++seed) {
      group.push_back(std::make_unique<G>(static_cast<std::uint64_t>(seed)));
      text += group.back()->source.text;
    }
    const Compiled library(text);
    for (std::size_t k = 0; k < group.size(); ++k) {
      SCOPED_TRACE("seed " + std::to_string(first + static_cast<int>(k)));
      G& generated = *group[k];
      Trial<T>& trial = generated.trial;
      const Model& model = trial.model;
      coupled += model.n_screws() > model.nv();
      for (int s = 0; s < 4; ++s) {
        const State<T> state = cast<T>(random_state(model, generated.random));
        const std::vector<T>&q = state.q, &v = state.v, &a = state.a;
        std::vector<T> tau = trial.zero(), expected = tau, back = tau, found = tau;
        inverse_dynamics(model, trial.workspace, q, v, a, expected);
        generated.template function<typename G::OfState>(library, 0)(q.data(), v.data(), a.data(),
                                                                     tau.data());
        force.expect_equal(tau, expected);

        const int doubt = generated.template function<typename G::Solve>(library, 1)(
            q.data(), v.data(), expected.data(), found.data());
        const bool ok = forward_dynamics(model, trial.workspace, q, v, expected, back).ok();
        EXPECT_TRUE(ok || doubt == 1) << "a singular mass matrix is told";
        singular += !ok, doubted += ok && doubt == 1;
        if (doubt ==
            0) {  // accelerations may be as ill-conditioned as M: compared by the forces that they need
          ++solved;
          inverse_dynamics(model, trial.workspace, q, v, found, back);
          force.expect_equal(back, expected);
        }

        std::vector<T> M(tau.size() * tau.size()), J(6 * tau.size()), M_expected = M;
        mass_matrix(model, trial.workspace, q, M_expected);
        generated.template function<typename G::OfConfiguration>(library, 2)(q.data(), M.data());
        inertia.expect_equal(M, M_expected);
        generated.template function<typename G::OfConfiguration>(library, 3)(q.data(), J.data());
        columns.expect_equal(J, library_jacobian(trial, generated.jacobian, q));
      }
    }
  }
  EXPECT_GE(singular, 10);
  EXPECT_GE(solved, 100);
  EXPECT_GE(coupled, 5);
  EXPECT_LE(doubted, solved / 20) << "doubt is rare where the library finds accelerations";
}

/// What a compiler says about C source.
std::string complaints(const std::string& source, std::vector<std::string> words) {
  const TemporaryFolder folder;
  const std::string file = folder.write("generated.c", source);
  words.insert(words.begin(), AXODE_COMPILER);
  words.insert(words.end(), {"-Wall", "-Wextra", "-pedantic", "-Werror", "-fsyntax-only", file});
  return run(words).err;
}

TYPED_TEST(GeneratedCode, CompilesWithoutWarningsAsC99AndAsCpp) {
  const std::vector<Function> functions{{Quantity::inverse_dynamics},
                                        {Quantity::forward_dynamics},
                                        {Quantity::mass_matrix},
                                        {Quantity::jacobian, 0},
                                        {Quantity::jacobian, 2, Representation::mixed}};
  for (const auto& [file, base] :
       {std::pair("arm7.toml", Base::fixed), std::pair("machine.toml", Base::as_described),
        std::pair("humanoid.urdf", Base::free)}) {
    const codegen::Source source =
        codegen::c_source(load(robot(file), base), functions,
                          {.prefix = "robot", .single_precision = std::same_as<TypeParam, float>});
    EXPECT_EQ(complaints(source.text, {"-x", "c", "-std=c99"}), "") << file;
    EXPECT_EQ(complaints(source.text, {"-x", "c++"}), "") << file;
    EXPECT_NE(complaints(source.text, {"-x", "c", "-std=c99", "-ffast-math"}), "") << file;
  }
}

/// Three hinges through one point, z, y, z, of which only the last one carries something: where the first and
/// the last axis meet, the mass matrix is singular.
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

TYPED_TEST(GeneratedCode, TellsWhereTheMassMatrixIsSingular) {
  using T = TypeParam;
  const std::vector<Function> functions{{Quantity::forward_dynamics}};
  const bool single = std::same_as<T, float>;
  const Compiled library(codegen::c_source(wrist(), functions, {"wrist", single}).text);
  const Compiled massless(codegen::c_source(wrist(0), functions, {"wrist", single}).text);
  const T straight[]{T(0.3), T(0), T(0.2)}, bent[]{T(0.3), T(1), T(0.2)}, zero[]{T(0), T(0), T(0)};
  T a[3];
  const char* name = "wrist_forward_dynamics";
  EXPECT_EQ(library.function<typename Generated<T>::Solve>(name)(bent, zero, zero, a), 0);
  EXPECT_EQ(library.function<typename Generated<T>::Solve>(name)(straight, zero, zero, a), 1);
  EXPECT_EQ(massless.function<typename Generated<T>::Solve>(name)(bent, zero, zero, a), 1);
}

/// The turning point of a crank of 1 m moves with -sin q and cos q.
TYPED_TEST(GeneratedCode, HasSinesAndCosinesOfTwoUnitsInTheLastPlace) {
  using T = TypeParam;
  const Model crank = ModelBuilder("crank")
                          .add({.name = "crank", .joint = {.kind = JointKind::revolute, .axis = {0, 0, 1}}})
                          .add(FrameDescription{.name = "pin", .body = "crank", .pose = {{}, {1, 0, 0}}})
                          .build();
  const std::vector<Function> functions{
      {Quantity::jacobian, crank.frame_index("pin"), Representation::hybrid}};
  const Compiled library(codegen::c_source(crank, functions, {"crank", std::same_as<T, float>}).text);
  const auto function = library.function<typename Generated<T>::OfConfiguration>("crank_jacobian_pin_hybrid");
  Random<double> random(1);
  const auto units = [](T x, double exact) {
    const T nearest = static_cast<T>(exact);
    const double unit = std::abs(static_cast<double>(std::nextafter(nearest, T(2)) - nearest));
    return std::abs(static_cast<double>(x) - exact) / unit;
  };
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
}

/// Every operation of a tape, with sines of sines, as a function of C.
TYPED_TEST(GeneratedCode, ComputesWhatIsRecorded) {
  using T = TypeParam;
  const auto computed = [](auto x, auto y, auto z) {
    using N = decltype(x);
    const N a = sin(x) * cos(y) + z / (N(2) + x * x), b = sqrt(N(1) + a * a) - N(3) * y,
            c = atan2(b, sin(a) - y);
    const auto less = [](const N& u, const N& v) { return !(v <= u); };
    return std::vector<N>{
        a, -b, N(0.1) * c, N(7), x, select(x < y && y <= z, a, b), select(less(z, a) || y < x, a, -a)};
  };
  codegen::Recording recording{.arguments = {"q"}, .result = "f"};
  {
    Tape tape;
    recording.results = computed(tape.input(0, 0), tape.input(0, 1), tape.input(0, 2));
    recording.nodes = tape.nodes();
  }
  EXPECT_TRUE(codegen::calls_math_library(recording));
  const codegen::Precision precision{std::same_as<T, float>};
  const Compiled library("#include <math.h>\n#define AXODE_RESTRICT restrict\n" +
                         codegen::c_sine_cosine("turn", precision) +
                         codegen::c_definition(recording, "f_of_q", "turn", precision));
  const auto function = library.function<typename Generated<T>::OfConfiguration>("f_of_q");
  Comparison value("value", std::same_as<T, double> ? 1e-14 : 1e-5);
  Random<double> random(7);
  for (int trial = 0; trial < 1000; ++trial) {
    const T q[]{static_cast<T>(random.number(-1, 1)), static_cast<T>(random.number(-1, 1)),
                static_cast<T>(random.number(-1, 1))};
    std::vector<T> f(7);
    function(q, f.data());
    value.expect_equal(f, computed(q[0], q[1], q[2]));
  }
}

/// Of the 150 products and sums that the fast path takes for a hinge, an arm with axes at right angles needs
/// about a third.
TEST(GeneratedOperations, AreOnlyThoseThatTheMechanismNeeds) {
  const std::vector<Function> functions{{Quantity::inverse_dynamics}, {Quantity::mass_matrix}};
  const codegen::Source arm = codegen::c_source(load(robot("arm7.toml")), functions);
  const Operations &forces = arm.functions[0].operations, &matrix = arm.functions[1].operations;
  EXPECT_LE(forces.products + forces.sums, 7 * 54);
  EXPECT_EQ(forces.angles, 12) << "gravity is along the first axis";
  EXPECT_EQ(matrix.angles, 10) << "M depends neither on the first angle nor on the last";
  EXPECT_EQ(forces.divisions + matrix.divisions, 0);
}

TEST(GeneratedNames, AreIdentifiersAndNoTwoAreTheSame) {
  ModelBuilder builder("7 of 9");
  builder.add({.name = "link */ 1", .joint = {.kind = JointKind::revolute, .axis = {0, 0, 1}}});
  for (const char* name : {"tool 1", "tool_1", "tool-1", "tool_1_2"})
    builder.add(FrameDescription{.name = name, .body = "link */ 1"});
  const Model model = builder.build();
  std::vector<Function> functions;
  for (int f = 0; f < model.n_frames(); ++f) functions.push_back({Quantity::jacobian, f});
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
  EXPECT_EQ(call({}), "there are no functions to generate");
  EXPECT_EQ(call({{Quantity::mass_matrix}}, "7th"),
            "the prefix \"7th\" is no C identifier: letters, digits and underscores, no digit first");
  EXPECT_EQ(call({{Quantity::jacobian, 9}}), "frame is 9; model \"wrist\" has frames 0 to 3");
  EXPECT_EQ(call({{Quantity::mass_matrix}, {Quantity::mass_matrix}}), "wrist_mass_matrix is asked for twice");
}

}  // namespace
}  // namespace axode::test
