#pragma once
#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "axode/lie/twist.hpp"
#include "axode/model/model.hpp"
#include "axode/scalar/counted.hpp"
#include "axode/table/functions.hpp"

/// Generates C source for one mechanism: functions with only the operations that this mechanism needs,
/// without loops over joints. To find these operations, the algorithms of the library are run on numbers that
/// record them.
namespace axode::codegen {

/// A function to generate: a function in the table of functions that can be recorded (Words::tape).
struct Function {
  catalog::Id row;
  int frame = 0;                                         ///< the frame of a Jacobian or a pose
  Representation representation = Representation::body;  ///< the representation of a Jacobian

  std::string_view name() const { return row.words().name; }
  /// Whether the function is about one frame, as poses and Jacobians of frames are.
  bool is_of_a_frame() const { return row.words().takes_input(catalog::Input::place); }
  bool is(catalog::Id id) const { return row == id; }
};
/// The names of all functions in the table of functions that can be recorded, in its order.
inline constexpr auto recorded_functions = [] {
  constexpr auto is_recorded = [](const catalog::Words& row) -> bool { return row.tape; };
  std::array<std::string_view, std::ranges::count_if(catalog::functions_of_state, is_recorded)> names{};
  std::size_t n = 0;
  for (const catalog::Words& row : catalog::functions_of_state)
    if (row.tape) names[n++] = row.name;
  return names;
}();

/// The kind of caller for which functions are generated. It determines the signatures of the functions.
enum class Abi {
  plain,   ///< C or C++: see c_source()
  casadi,  ///< CasADi: see casadi_source.hpp
  cuda     ///< threads of a GPU: see cuda_kernel.hpp
};
/// The names of the values of Abi, in their order.
inline constexpr std::array<std::string_view, 3> abis{"plain", "casadi", "cuda"};

struct Options {
  std::string prefix;             ///< a C identifier that all names begin with; the model's name if empty
  bool single_precision = false;  ///< float instead of double
  Abi abi = Abi::plain;
  int states = 1;  ///< number of states that one call of a function of CasADi takes
};

/// The text of a file in C99 or CUDA that needs no other file to be compiled, and the cost of each of its
/// functions.
struct Source {
  struct Cost {
    std::string name;
    Operations operations;  ///< operations of one call; the sine and the cosine of one angle count as two
                            ///< `angles`
  };
  std::string text;
  std::vector<Cost> functions;
};

/// Whether a name has only ASCII letters, digits and underscores, and does not begin with a digit.
bool is_identifier(std::string_view name);

/// Generates C or CUDA functions of a model. Each function has the units, frames, coordinates and results of
/// the library's function of the same name. PREFIX stands for options.prefix or, if this is empty, for the
/// model's name, NAME for a frame's name as an identifier, and T for double or float:
///
///     void PREFIX_inverse_dynamics(const T *q, const T *v, const T *a, T *tau)
///     int  PREFIX_forward_dynamics(const T *q, const T *v, const T *tau, T *a)
///     void PREFIX_mass_matrix(const T *q, T *M)
///     int  PREFIX_inverse_mass_matrix(const T *q, T *M_inverse)
///     void PREFIX_poses(const T *q, T *C)
///     void PREFIX_pose_NAME(const T *q, T *C)
///     void PREFIX_jacobian_NAME(const T *q, T *J)
///     void PREFIX_inverse_dynamics_derivatives(const T *q, const T *v, const T *a, T *dtau)
///     void PREFIX_inverse_dynamics_jvp(const T *q, const T *v, const T *a, const T *dq, const T *dv,
///                                      const T *da, T *dtau)
///     void PREFIX_inverse_dynamics_vjp(const T *q, const T *v, const T *a, const T *w, T *gradient)
///     void PREFIX_inverse_dynamics_hessian(const T *q, const T *v, const T *a, const T *w, T *hessian)
///     int  PREFIX_forward_dynamics_derivatives(const T *q, const T *v, const T *tau, T *da)
///     int  PREFIX_forward_dynamics_jvp(...), ..._vjp(...), PREFIX_forward_dynamics_hessian(...)
///
/// A function with the ending _jvp computes the directional derivative of tau (or a) along dq, dv and da (or
/// dtau); _vjp and _hessian compute the gradient and the second derivatives of the sum of the entries of tau
/// (or a) with the nv weights w. All matrices are stored row by row. In functions with the ending
/// _derivatives, dtau (or da) has three nv x nv matrices one after the other: the derivatives by q, by v and
/// by a (or tau), with a row for each entry of tau (or a). A gradient has the derivatives in the same order,
/// nv numbers each. A Hessian has four nv x nv matrices one after the other, for the pairs of variables
/// (q, q), (q, v), (v, v) and (a or tau, q), with a row for each entry of the first variable. M and its
/// inverse are nv x nv. C has 12 numbers for each frame, the columns of R and then r. J is 6 x nv, angular
/// before linear, in the body-fixed representation; the name of a function for another representation ends
/// with it, as in PREFIX_jacobian_NAME_spatial. The functions of forward dynamics and of M_inverse return 0,
/// or 1 if the mass matrix may be singular; their result is then unreliable. Arrays must not overlap.
/// Armature and gravity are those of the model; joint losses and loads are left out. Results differ from the
/// library's by rounding, for angles up to 1e5 rad.
///
/// In CUDA, n states are stored side by side: entry k of state i is x[k n + i]. For each function there is a
/// device function, which one thread calls with pointers to the first entries of its state,
///
///     void PREFIX_inverse_dynamics(const T *q, const T *v, const T *a, T *tau, int n)
///
/// and a kernel for n states, with a thread for each state:
///
///     void PREFIX_inverse_dynamics_states(const T *q, const T *v, const T *a, T *tau, int n)
///
/// The kernel writes NaN for a state if the device function returns 1. Angles may have any size in CUDA.
///
/// The time and the memory that generated functions take are proportional to their operations: O(nv), O(nv²)
/// for matrices, and O(nv² d) for the Hessian of forward dynamics of a tree of depth d. Throws
/// std::invalid_argument for a prefix that is no C identifier, a frame that does not exist, an empty list of
/// functions, and a function that is in the list twice.
Source c_source(const Model& model, std::span<const Function> functions, const Options& options = {});

}  // namespace axode::codegen
