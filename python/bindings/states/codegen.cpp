#include "python/bindings/states/codegen.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include "axode/codegen/compiled/machine_code.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/bound_model.hpp"
#include "python/bindings/support/choice.hpp"
#include "python/bindings/support/long_call.hpp"
#include "python/bindings/support/named_tuple.hpp"
#include "python/bindings/support/text.hpp"

namespace axode::python {
namespace {

using namespace nb::literals;

[[noreturn]] void wrong_function(const std::string& where, nb::handle given) {
  throw nb::value_error((where + " is " + shown(given) +
                         "; expected a name, or (\"jacobian\", frame), (\"jacobian\", frame, representation) "
                         "or (\"pose\", frame)")
                            .c_str());
}

/// Parses a request for generated code: the name of a function, or a tuple ("jacobian", frame), ("jacobian",
/// frame, representation) or ("pose", frame). `where` names the argument in messages.
codegen::Function function_from(const Model& model, const std::string& where, nb::handle given) {
  const bool is_tuple = PyTuple_Check(given.ptr());
  if (!is_tuple && !nb::isinstance<nb::str>(given)) wrong_function(where, given);
  const std::size_t entries = is_tuple ? nb::len(given) : 1;
  if (entries == 0 || entries > 3) wrong_function(where, given);
  const nb::object word = is_tuple ? nb::object(given[0]) : nb::borrow(given);
  const std::size_t chosen = choose(where.c_str(), word, codegen::recorded_functions);
  codegen::Function function{*catalog::Id::of(codegen::recorded_functions[chosen])};
  if (function.is_of_a_frame() != (entries > 1) || (function.is("pose") && entries > 2))
    wrong_function(where, given);
  if (entries > 1)
    function.frame = FrameName{nb::object(given[1]).ptr()}.in(model, (where + ", frame").c_str());
  if (entries > 2)
    function.representation = Words<Representation>::value(
        choose((where + ", representation").c_str(), nb::object(given[2]), Words<Representation>::words));
  return function;
}

nb::object c_source_of(const BoundModel& m, nb::handle functions, const std::string& prefix,
                       bool single_precision, nb::handle abi) {
  const std::vector<codegen::Function> wanted = functions_from(m, functions);
  const auto caller = static_cast<codegen::Abi>(choose("abi", abi, codegen::abis));
  const codegen::Source source = [&] {
    const nb::gil_scoped_release released;
    return codegen::c_source(m, wanted, {prefix, single_precision, caller});
  }();
  nb::list costs;
  for (const auto& [name, n] : source.functions)
    costs.append(
        named_tuple("axode.codegen", "Cost", name, n.products, n.sums, n.divisions, n.roots, n.angles));
  return named_tuple("axode.codegen", "Source", source.text, costs);
}

/// A shared library with external functions of CasADi. The library stays loaded as long as the object exists.
struct CasadiLibrary {
  std::string name;
  codegen::MachineCode code;
};

std::unique_ptr<CasadiLibrary> casadi_library(const BoundModel& m, nb::handle quantity, int states,
                                              const std::optional<std::vector<std::string>>& flags) {
  const codegen::Function function = function_from(m, "quantity", quantity);
  LongCall call(true);
  std::unique_ptr<CasadiLibrary> library;
  try {
    const codegen::Source source =
        codegen::c_source(m, {&function, 1}, {.abi = codegen::Abi::casadi, .states = states});
    library.reset(new CasadiLibrary{
        source.functions[0].name, {source.text, flags.value_or(SpecialisedOptions{}.flags), call.monitor()}});
  } catch (const CompilationEnded&) {
  }
  call.end();
  return library;
}

}  // namespace

std::vector<codegen::Function> functions_from(const Model& model, nb::handle functions) {
  if (!PyList_Check(functions.ptr()) && !PyTuple_Check(functions.ptr()))
    throw nb::value_error(
        (std::string("functions is ") + shown(functions) + "; expected a list of functions").c_str());
  std::vector<codegen::Function> wanted;
  for (const nb::handle each : functions)
    wanted.push_back(function_from(model, "functions[" + std::to_string(wanted.size()) + "]", each));
  return wanted;
}

void add_codegen(nb::module_& module) {
  module.def(
      "c_source", &c_source_of, "m"_a, "functions"_a, "prefix"_a = "", "single_precision"_a = false,
      "abi"_a = "plain",
      nb::sig("def c_source(m: axode.Model, functions: collections.abc.Sequence[axode.codegen.Function], "
              "prefix: str = '', single_precision: bool = False, abi: typing.Literal['plain', 'casadi', "
              "'cuda'] = "
              "'plain') -> axode.codegen.Source"),
      R"(
Generates a file in C99, or in CUDA, for one mechanism, which needs nothing but a compiler, and counts the operations
of each of its functions.

functions are "inverse_dynamics", "forward_dynamics", either of these followed by "_derivatives", "_jvp", "_vjp" or
"_hessian", "mass_matrix", "inverse_mass_matrix", "poses", ("pose", frame), ("jacobian", frame) and ("jacobian",
frame, representation). With PREFIX for prefix (made from the model's name if empty), NAME for the frame's name and T
for double or, in single precision, float, they become

    void PREFIX_inverse_dynamics(const T *q, const T *v, const T *a, T *tau)
    int  PREFIX_forward_dynamics(const T *q, const T *v, const T *tau, T *a)
    void PREFIX_mass_matrix(const T *q, T *M)
    int  PREFIX_inverse_mass_matrix(const T *q, T *M_inverse)
    void PREFIX_poses(const T *q, T *C), PREFIX_pose_NAME(const T *q, T *C)
    void PREFIX_jacobian_NAME(const T *q, T *J), PREFIX_jacobian_NAME_hybrid, ...
    void PREFIX_inverse_dynamics_derivatives(const T *q, const T *v, const T *a, T *dtau), ...

with the units and frames of the functions of the same names in Python. M and its inverse are (nv, nv) and J is (6,
nv), row by row; C has the columns of R and then r of each frame, 12 numbers. Derivatives by q, v and a or tau are
contiguous, and so are the blocks of a Hessian, as in `InverseDynamicsHessian` and `ForwardDynamicsHessian`.
forward_dynamics, its derivatives and inverse_mass_matrix return 0, or 1 if the mass matrix may be singular. Armature
and gravity are included, joint losses and loads are not. Results differ from those of the library by rounding, for
angles up to 1e5 rad. Compile the file without -ffast-math.

With abi="casadi" they are external functions of CasADi with their derivatives, see `axode.casadi`. With abi="cuda"
they are device functions whose last argument is n, and PREFIX_..._states are kernels for n states that lie side by
side; `axode.cuda` calls them. KeyError for an unknown frame. ValueError for an unknown function, a function that is
in the list twice, an empty list, an unknown abi and a prefix that is not a C identifier.

>>> source = axode.codegen.c_source(arm, ["inverse_dynamics", ("jacobian", "flange", "hybrid")], prefix="arm")
>>> [cost.name for cost in source.functions]
['arm_inverse_dynamics', 'arm_jacobian_flange_hybrid']
>>> "void arm_inverse_dynamics(" in source.text
True
)");
  nb::class_<CasadiLibrary>(module, "CasadiLibrary", "An external function of CasADi in a shared library.")
      .def_ro("name", &CasadiLibrary::name, "Name of the function.")
      .def_prop_ro(
          "file", [](const CasadiLibrary& library) { return library.code.file().string(); },
          "Path of the library: in the cache, or in a temporary folder if there is no cache.");
  module.def("casadi_library", &casadi_library, "m"_a, "quantity"_a, "states"_a = 1, nb::kw_only(),
             "flags"_a = nb::none(),
             nb::sig("def casadi_library(m: axode.Model, quantity: object, states: int = 1, *, flags: "
                     "collections.abc.Sequence[str] | None = None) -> axode._axode.codegen.CasadiLibrary"),
             "One function of c_source with the abi \"casadi\", compiled and kept as those of "
             "`Model.specialise` are.");
}

}  // namespace axode::python
