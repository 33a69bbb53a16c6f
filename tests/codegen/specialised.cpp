#include <algorithm>
#include <limits>
#include <numbers>
#include <numeric>
#include <thread>
#include <tuple>

#include "axode/codegen.hpp"
#include "axode/io.hpp"
#include "axode/model/building/builder.hpp"
#include "axode/model/configuration.hpp"
#include "tests/codegen/specialised_models.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/refused_arguments.hpp"

/// Specialised models give the same results as the library. Without their cache or without a compiler they
/// still do what is possible.
namespace axode::test {
namespace {

using catalog::Id;
using codegen::Function;

template <class T> const catalog::Function<T>& row(const Function& function) {
  const std::string_view name = function.name();
  if (!function.is("jacobian")) return *catalog::find<Fast, T>(name);
  return with_representation(function.representation, [&]<class Rep>(Rep) -> const catalog::Function<T>& {
    return *catalog::find<Rep, T>(name);
  });
}

std::vector<Function> all_functions(const Model& model) {
  std::vector<Function> functions;
  for (const std::string_view name : codegen::recorded_functions)
    if (name != "pose")  // functions for poses return all of them
      functions.push_back({*Id::of(name), model.n_frames() - 1, Representation::hybrid});
  return functions;
}

template <class T> T largest_of(std::span<const T> x) {
  T largest = 0;
  for (const T each : x) largest = std::max(largest, std::abs(each));
  return largest;
}

/// Compares all functions in N states with those of the library. Results that are divided by the mass matrix
/// may be less exact, depending on its condition.
template <class T>
void expect_what_the_library_gives(const Model& model, const Specialised<T>& specialised,
                                   const std::vector<Function>& functions, std::size_t N, double tolerance) {
  const RandomStates<T> states(model, N, N);
  Workspace<T> workspace(model);
  for (const Function& function : functions) {
    const catalog::Function<T>& library = row<T>(function);
    SCOPED_TRACE(std::string(library.name) + " of " + model.name());
    const std::size_t size = library.size(model, 0);
    std::vector<T> result(size * N), expected(size);
    const batch::Outcome outcome =
        batch::run(specialised, function, states.given(model, library, 0, N), result);
    EXPECT_EQ(outcome.done, N);
    std::size_t singular = 0;
    for (std::size_t k = 0; k < N; ++k) {
      catalog::Arguments<T> one = states.given(model, library, k, 1);
      one.place = function.frame;
      singular += !library.call(model, workspace, one, expected).ok();
      const std::span<const T> found = std::span(result).subspan(k * size, size);
      const double scale = std::max<double>(largest_of<T>(expected), 1e-6);
      for (std::size_t i = 0; i < size; ++i)
        if (std::isfinite(expected[i])) {
          ASSERT_NEAR(found[i], expected[i], tolerance * scale) << k << ' ' << i;
        }
    }
    EXPECT_EQ(outcome.singular_states, singular);
  }
}

TEST_F(SpecialisedModels, GiveWhatTheLibraryGivesInEveryNumberOfStates) {
  const Model model = load(robot("double_pendulum.toml"));
  const std::vector<Function> functions = all_functions(model);
  const Specialised<> doubles(model, functions, {.flags = quickly});
  const Specialised<float> floats(model, functions, {.flags = quickly});
  for (const std::size_t N : {1, 2, 3, 4, 5, 8, 11, 16, 17, 67, 200}) {
    expect_what_the_library_gives(model, doubles, functions, N, 1e-12);
    expect_what_the_library_gives(model, floats, functions, N, 1e-4);
  }
}

TEST_F(SpecialisedModels, AreTheSameInLanesOfEveryNumberAndWithoutVectors) {
  const Model model = load(robot("double_pendulum.toml"));
  const std::vector<Function> functions{{Id("inverse_dynamics")}, {Id("forward_dynamics")}, {Id("poses")}};
  for (const int lanes : {1, 2, 4, 8, 16}) {
    expect_what_the_library_gives(model, Specialised<>(model, functions, {.lanes = lanes, .flags = quickly}),
                                  functions, 19, 1e-12);
    expect_what_the_library_gives(
        model, Specialised<float>(model, functions, {.lanes = lanes, .flags = quickly}), functions, 19, 1e-4);
  }
  expect_what_the_library_gives(model, Specialised<>(model, functions, {.flags = {"-O1"}}), functions, 19,
                                1e-12);
  EXPECT_EQ(message_of([&] { Specialised<>(model, functions, {.lanes = 3}); }),
            "lanes is 3; expected 1, 2, 4, 8 or 16");
}

TEST_F(SpecialisedModels, TurnByAnglesOfEverySize) {
  const Model model = load(robot("double_pendulum.toml"));
  const Specialised<> specialised(model, {{Id("poses")}}, {.flags = quickly});
  const std::vector<double> angles{0, -1e-9, 3, -99'999, 1e5, -1e6, 1e9, 1e15, 1e22, -1e300};
  std::vector<double> q;
  for (const double one : angles)
    for (const double other : angles) q.insert(q.end(), {one, other});
  const std::size_t N = q.size() / 2, size = 12 * static_cast<std::size_t>(model.n_frames());
  std::vector<double> C(N * size), expected(size);
  ASSERT_TRUE(batch::run(specialised, {"poses"}, {.q = q}, C).ok());
  Workspace<> workspace(model);
  for (std::size_t k = 0; k < N; ++k) {
    std::ignore =
        row<double>({Id("poses")}).call(model, workspace, {.q = std::span(q).subspan(2 * k, 2)}, expected);
    for (std::size_t i = 0; i < size; ++i) EXPECT_NEAR(C[k * size + i], expected[i], 1e-14);
  }
}

TEST_F(SpecialisedModels, TellWhichStatesAreSingularAndWhichOverflow) {
  const Model wrist = singular_wrist();
  const Function function{Id("forward_dynamics")};
  const std::vector<double> q(20), v(20), tau(20, 1);
  std::vector<double> a(20);
  const batch::Outcome singular = batch::run(Specialised<>(wrist, {function}, {.flags = quickly}), function,
                                             {.q = q, .v = v, .tau = tau}, a);
  EXPECT_EQ(singular.singular_states, 10u);
  EXPECT_FALSE(singular.solvability.ok() || singular.solvability.not_finite);

  const Model pendulum = load(robot("double_pendulum.toml"));
  std::vector<double> fast(20);
  fast[6] = 1e200;
  const batch::Outcome overflow = batch::run(Specialised<>(pendulum, {function}, {.flags = quickly}),
                                             function, {.q = q, .v = fast, .tau = tau}, a);
  EXPECT_EQ(overflow.singular_states, 1u);
  EXPECT_EQ(overflow.first, 3u);
  EXPECT_TRUE(overflow.solvability.not_finite);
}

TEST_F(SpecialisedModels, CheckTheirArguments) {
  const Model model = load(robot("double_pendulum.toml"));
  const Function function{Id("inverse_dynamics")};
  const Specialised<> specialised(model, {function}, {.flags = quickly});
  std::vector<double> q(6), v(6), tau(6), short_of_one(5);
  const auto message = [&](const Function& of, const catalog::Arguments<double>& given,
                           std::span<double> out) {
    return message_of([&] { static_cast<void>(batch::run(specialised, of, given, out)); });
  };
  EXPECT_EQ(message(function, {.q = q, .v = short_of_one, .a = v}, tau),
            "v has 5 entries; expected nv N = 6");
  EXPECT_EQ(message(function, {.q = short_of_one, .v = v, .a = v}, tau),
            "q has 5 entries; expected a multiple of nq = 2");
  EXPECT_EQ(message(function, {.q = q, .v = v, .a = v}, short_of_one),
            "tau has 5 entries; expected nv N = 6");
  EXPECT_EQ(message(function, {.q = q, .v = v, .a = v}, q),
            "tau shares memory with q; this result needs memory of its own");
  EXPECT_EQ(message({Id("mass_matrix")}, {.q = q}, tau),
            "model \"double pendulum\" was specialised without mass_matrix");
  EXPECT_EQ(message(function, {.q = q, .v = v, .a = v, .loads = {.joint_losses = true}}, tau),
            "loads: specialised functions take no loads and no joint losses");
  EXPECT_TRUE(specialised.has(function));
  EXPECT_FALSE(specialised.has({Id("poses")}));
}

TEST_F(SpecialisedModels, WithoutDegreesOfFreedomHaveNoStates) {
  const Model model =
      ModelBuilder("block").add({.name = "block", .joint = {.kind = JointKind::fixed}}).build();
  const std::vector<Function> functions = all_functions(model);
  const Specialised<> specialised(model, functions, {.flags = quickly});
  for (const Function& function : functions) EXPECT_EQ(batch::run(specialised, function, {}, {}).done, 0u);
}

TEST_F(SpecialisedModels, AreShared) {
  const Model model = load(robot("double_pendulum.toml"));
  const std::vector<Function> functions{{Id("forward_dynamics")}};
  const Specialised<> specialised(model, functions, {.flags = quickly});
  std::vector<std::thread> threads;
  for (int k = 0; k < 8; ++k)
    threads.emplace_back([&] {
      for (int repeat = 0; repeat < 20; ++repeat)
        expect_what_the_library_gives(model, specialised, functions, 50, 1e-12);
    });
  for (std::thread& thread : threads) thread.join();

  const RandomStates<double> all(model, 1000, 3);
  const catalog::Arguments<double> given = all.given(model, functions[0].row.words(), 0, 1000);
  std::vector<double> alone(2000), together(2000);
  ASSERT_TRUE(batch::run(specialised, functions[0], given, alone, 1).ok());
  ASSERT_TRUE(batch::run(specialised, functions[0], given, together, 4).ok());
  EXPECT_EQ(alone, together);
}

std::vector<std::string> files(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.push_back(entry.path().filename());
  std::ranges::sort(names);
  return names;
}

TEST_F(SpecialisedModels, AreKeptAndCompiledAgainWhereWhatWasKeptIsSpoilt) {
  const Model model = load(robot("double_pendulum.toml"));
  const std::vector<Function> functions{{Id("inverse_dynamics")}};
  EXPECT_EQ(specialised_cache().models, 0u);
  const auto make = [&] {
    expect_what_the_library_gives(model, Specialised<>(model, functions, {.flags = quickly}), functions, 5,
                                  1e-12);
  };
  make();
  const SpecialisedCache kept = specialised_cache();
  EXPECT_EQ(kept.folder, folder.file("axode"));
  ASSERT_EQ(kept.models, 1u);
  EXPECT_GT(kept.bytes, 1000u);
  const std::vector<std::string> names = files(kept.folder);
  ASSERT_EQ(names.size(), 2u) << "a library and the lock";
  const std::filesystem::path library = std::filesystem::path(kept.folder) / names[0];
  const auto time = std::filesystem::last_write_time(library);
  make();
  EXPECT_EQ(std::filesystem::last_write_time(library), time);

  for (const std::size_t length : {std::size_t{0}, std::size_t{40}, std::size_t{2000}}) {
    std::filesystem::resize_file(library, length);
    make();
    EXPECT_EQ(specialised_cache().bytes, kept.bytes);
  }
  std::fstream(library, std::ios::in | std::ios::out | std::ios::binary).seekp(1000).write("spoilt", 6);
  make();
  EXPECT_EQ(files(kept.folder), names);
  Specialised<>(model, functions, {.flags = {"-O1"}});
  EXPECT_EQ(specialised_cache().models, 2u);

  std::filesystem::create_directory(library.string().replace(library.string().size() - 2, 2, "killed"));
  clear_specialised_cache();
  EXPECT_EQ(specialised_cache().models, 0u);
  EXPECT_EQ(files(kept.folder), std::vector<std::string>{"lock"});
}

TEST_F(SpecialisedModels, NeedNoCache) {
  const Model model = load(robot("double_pendulum.toml"));
  const std::vector<Function> functions{{Id("inverse_dynamics")}};
  const Variable nowhere("XDG_CACHE_HOME", "/proc/nowhere");
  expect_what_the_library_gives(model, Specialised<>(model, functions, {.flags = quickly}), functions, 5,
                                1e-12);
  EXPECT_EQ(specialised_cache().models, 0u);
}

TEST_F(SpecialisedModels, AreNotTakenFromAFolderInWhichOthersWrite) {
  const Model model = load(robot("double_pendulum.toml"));
  const std::vector<Function> functions{{Id("inverse_dynamics")}};
  std::filesystem::create_directory(folder.file("axode"));
  std::filesystem::permissions(folder.file("axode"), std::filesystem::perms::all);
  expect_what_the_library_gives(model, Specialised<>(model, functions, {.flags = quickly}), functions, 5,
                                1e-12);
  EXPECT_TRUE(files(folder.file("axode")).empty());
}

TEST_F(SpecialisedModels, SayWhereThereIsNoCompilerOrItFails) {
  const Model model = load(robot("double_pendulum.toml"));
  const auto make = [&](const SpecialisedOptions& options) {
    try {
      Specialised<>(model, {{Id("inverse_dynamics")}}, options);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(
      make({.flags = {"--nothing"}}),
      testing::MatchesRegex(
          "the compiler .*/cc failed on a specialised model with exit code 1:\n(.|\n)*--nothing(.|\n)*"));
  EXPECT_THAT(make({.monitor = [](std::size_t, std::size_t) { return false; }}),
              testing::HasSubstr("was interrupted"));
  EXPECT_EQ(files(folder.file("axode")), std::vector<std::string>{"lock"});
  const Variable path("PATH", "");
  const Variable none("CC", "/nonexistent");
  EXPECT_EQ(make({}),
            "there is no C compiler to specialise a model with: $CC is \"/nonexistent\", which cannot be "
            "run, and neither cc "
            "nor clang nor gcc is on the PATH");
}

}  // namespace
}  // namespace axode::test
