#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "python/bindings/states/codegen.hpp"
#include "python/bindings/states/specialised.hpp"
#include "python/bindings/states/state_function.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/named_tuple.hpp"

namespace axode::python {

using namespace nb::literals;
using codegen::Function;

void BoundSpecialised::check(const Function& wanted) const {
  if (!std::visit([&](const auto& functions) { return functions.has(wanted); }, functions_))
    throw nb::value_error(("this specialised model was made without " + std::string(wanted.name()) +
                           (wanted.is_of_a_frame() ? " of that frame in that representation" : "") +
                           "; name it among the functions of Model.specialise")
                              .c_str());
}

namespace {

batch::Outcome run(const BoundSpecialised& s, const Function& function,
                   const catalog::Arguments<double>& given, std::span<double> out, int threads,
                   const batch::Monitor& monitor) {
  if (const auto* doubles = std::get_if<Specialised<double>>(&s.functions()))
    return batch::run(*doubles, function, given, out, threads, monitor);
  const auto cast = [](std::span<const double> numbers) {
    return std::vector<float>(numbers.begin(), numbers.end());
  };
  std::array<std::vector<float>, catalog::inputs_of_numbers.size()> arguments;
  catalog::Arguments<double> doubles = given;
  catalog::Arguments<float> floats;
  for (std::size_t k = 0; k < arguments.size(); ++k) {
    arguments[k] = cast(catalog::numbers(doubles, catalog::inputs_of_numbers[k]));
    catalog::numbers(floats, catalog::inputs_of_numbers[k]) = arguments[k];
  }
  std::vector<float> result(out.size());
  const batch::Outcome outcome =
      batch::run(std::get<Specialised<float>>(s.functions()), function, floats, result, threads, monitor);
  std::ranges::copy(result, out.begin());
  return outcome;
}

nb::object as_float32(const nb::object& result) {
  if (!nb::isinstance<nb::tuple>(result)) return result.attr("astype")("float32");
  nb::list parts;
  for (const nb::handle part : result) parts.append(part.attr("astype")("float32"));
  return result.type()(*parts);
}

nb::object called(const BoundSpecialised& s, const Function& function, const StateFunction& f,
                  Arguments given) {
  s.check(function);
  const Instead instead = [&](const catalog::Arguments<double>& all, std::span<double> out,
                              const batch::Monitor& monitor) {
    return run(s, function, all, out, given.threads, monitor);
  };
  given.instead = &instead;
  nb::object result = f.all(s.model(), given);
  return s.is_single() ? as_float32(result) : result;
}

template <catalog::Id id> void define(nb::class_<BoundSpecialised>& type) {
  constexpr const catalog::Words& row = id.words();
  const char* const name = row.name.data();
  [&]<std::size_t... n>(std::index_sequence<n...>) {
    type.def(
        name,
        [f = StateFunction(name)](const BoundSpecialised& s, Each<ArrayLike, n>... numbers, int threads) {
          Arguments given{.q = {}, .threads = threads};
          ((given.*argument_of(id.words().numbers()[n]) = numbers), ...);
          return called(s, {id}, f, given);
        },
        parameter<row.numbers()[n]>()..., nb::kw_only(), nb::arg("threads") = 1,
        nb::sig(signature(row, "self", "*, threads: int = 1").c_str()),
        ("Computes `axode." + std::string(name) + "` by compiled code, without loads.").c_str());
  }
  (Times<row.numbers().size()>());
}

BoundSpecialised specialise(nb::handle_t<BoundModel> self, nb::handle functions, nb::handle scalar, int lanes,
                            const std::optional<std::vector<std::string>>& flags) {
  const BoundModel& m = *nb::inst_ptr<BoundModel>(self);
  const std::vector<Function> wanted = functions_from(m, functions);
  const bool single = choose("scalar", scalar, std::array<std::string_view, 2>{"float64", "float32"}) == 1;
  SpecialisedOptions options{.lanes = lanes};
  if (flags) options.flags = *flags;
  LongCall call(true);
  options.monitor = call.monitor();
  std::optional<BoundSpecialised::Any> made;
  try {
    if (single)
      made.emplace(Specialised<float>(m, wanted, options));
    else
      made.emplace(Specialised<double>(m, wanted, options));
  } catch (const CompilationEnded&) {
  }
  call.end();
  return {nb::borrow(self), std::move(*made)};
}

}  // namespace

void add_specialised(nb::module_& codegen) {
  nb::class_<BoundSpecialised> type(codegen, "Specialised", R"(
Functions that were compiled for one model by `Model.specialise`. Threads may share the object.

Each function has the arguments, results, checks and errors of the function of the same name in axode, for one state
or N states. ValueError for a function that was not compiled.

>>> s = arm.specialise(["mass_matrix"])
>>> q = arm.random(seed=1, n=100)
>>> np.allclose(s.mass_matrix(q), axode.mass_matrix(arm, q))
True
)");
  catalog::each_row([&]<catalog::Id id> {
    if constexpr (id.words().tape && !id.words().takes_input(catalog::Input::place)) define<id>(type);
  });
  type.def(
          "jacobian",
          [f = StateFunction("jacobian")](const BoundSpecialised& s, ArrayLike q, FrameName frame,
                                          Representation representation, int threads) {
            const Function function{"jacobian", frame.in(*s.model()), representation};
            return called(
                s, function, f,
                {.q = q, .algorithm = {representation}, .place = function.frame, .threads = threads});
          },
          "q"_a, "frame"_a, "representation"_a = "body", nb::kw_only(), "threads"_a = 1,
          nb::sig("def jacobian(self, q: numpy.typing.ArrayLike, frame: str | int, representation: "
                  "typing.Literal['body', 'spatial', 'hybrid', 'mixed'] = 'body', *, threads: int = 1) -> "
                  "numpy.typing.NDArray[numpy.float64]"),
          "Computes `axode.jacobian` by compiled code, for a frame and a representation that were named in "
          "Model.specialise.")
      .def_prop_ro(
          "model", [](const BoundSpecialised& s) { return s.python_model(); },
          nb::sig("def model(self) -> axode.Model"), "The model from which it was compiled.");

  nb::cpp_function_def(
      &specialise, nb::scope(nb::type<BoundModel>()), nb::name("specialise"), nb::is_method(), "functions"_a,
      "scalar"_a = "float64", nb::kw_only(), "lanes"_a = 16, "flags"_a = nb::none(),
      nb::sig("def specialise(self, functions: collections.abc.Sequence[axode.codegen.Function], scalar: "
              "typing.Literal['float64', 'float32'] = 'float64', *, lanes: int = 16, flags: "
              "collections.abc.Sequence[str] | None = None) -> axode.codegen.Specialised"),
      R"(
Compiles functions for this model, which makes them several times as fast: see `axode.codegen.Specialised`.

functions are those of `axode.codegen.c_source`. The first time, their C is compiled by $CC, cc, clang or gcc with
these flags (-O3 -march=native -ffp-contract=fast if they are left out); later it is taken from the cache, see
`axode.codegen.cache`. lanes is the largest number of states in a register: 1, 2, 4, 8 or 16; it is less if fewer
states fit into a register. In float32, results are arrays of float32. RuntimeError if there is no compiler or it
fails, ValueError for unknown functions.

>>> s = arm.specialise(["inverse_dynamics"], flags=["-O1"])
>>> q, v, a = np.full(7, 0.5), np.ones(7), np.zeros(7)
>>> np.allclose(s.inverse_dynamics(q, v, a), axode.inverse_dynamics(arm, q, v, a))
True
)");
  codegen.def(
      "cache",
      [] {
        const SpecialisedCache cache = specialised_cache();
        return named_tuple("axode.codegen", "Cache", cache.folder, cache.models, cache.bytes);
      },
      nb::sig("def cache() -> axode.codegen.Cache"), R"(
The cache of compiled functions: its folder, $XDG_CACHE_HOME/axode or ~/.cache/axode, the number of models in it, and
their bytes.

>>> axode.codegen.cache().bytes >= 0
True
)");
  codegen.def("clear_cache", &clear_specialised_cache, R"(
Removes all compiled functions from the cache. Functions that are loaded remain usable.

>>> axode.codegen.clear_cache()
>>> axode.codegen.cache().models
0
)");
}

}  // namespace axode::python
