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

/// C source for one mechanism: functions without loops and branches over its joints, in which only the
/// operations are left that this mechanism needs. They are what the kernels of the library do on a Trace.
namespace axode::codegen {

/// A function to generate: a row of the table that can be recorded.
struct Function {
  catalog::Id row;
  int frame = 0;                                         ///< of a Jacobian or a pose
  Representation representation = Representation::body;  ///< of a Jacobian

  std::string_view name() const { return row.words().name; }
  /// Whether there is one for each frame.
  bool is_of_a_frame() const { return row.words().takes_input(catalog::Input::place); }
  bool is(catalog::Id id) const { return row == id; }
};
/// The names of all, in the order of the table.
inline constexpr auto recorded_functions = [] {
  constexpr auto is_recorded = [](const catalog::Words& row) -> bool { return row.tape; };
  std::array<std::string_view, std::ranges::count_if(catalog::functions_of_state, is_recorded)> names{};
  std::size_t n = 0;
  for (const catalog::Words& row : catalog::functions_of_state)
    if (row.tape) names[n++] = row.name;
  return names;
}();

/// Who calls the functions, and therefore what they look like.
enum class Abi {
  plain,   ///< whoever has read their declarations
  casadi,  ///< CasADi: see casadi_source.hpp
  cuda     ///< threads of a GPU: see cuda_kernel.hpp
};
/// Their names, in that order.
inline constexpr std::array<std::string_view, 3> abis{"plain", "casadi", "cuda"};

struct Options {
  std::string prefix;             ///< of all names, a C identifier; made from the model's name if empty
  bool single_precision = false;  ///< float instead of double
  Abi abi = Abi::plain;
  int states = 1;  ///< of which functions of CasADi are
};

/// A file in C99 or CUDA that needs nothing but a compiler, and what each of its functions costs.
struct Source {
  struct Cost {
    std::string name;
    Operations operations;  ///< of one call; a sine and a cosine of one angle are two of `angles`
  };
  std::string text;
  std::vector<Cost> functions;
};

/// Whether a prefix will do: letters of ASCII, digits and underscores, no digit first.
bool is_identifier(std::string_view name);

/// The functions of a model, with the units, frames, coordinates and results of their namesakes in the
/// library, where PREFIX stands for the prefix, NAME for a frame's name as an identifier and T for double or
/// float:
///
///     void PREFIX_inverse_dynamics(const T *q, const T *v, const T *a, T *tau)
///     int  PREFIX_forward_dynamics(const T *q, const T *v, const T *tau, T *a)
///     void PREFIX_mass_matrix(const T *q, T *M)
///     int  PREFIX_inverse_mass_matrix(const T *q, T *M_inverse)
///     void PREFIX_poses(const T *q, T *C)
///     void PREFIX_pose_NAME(const T *q, T *C)
///     void PREFIX_jacobian_NAME(const T *q, T *J)
///     void PREFIX_inverse_dynamics_derivatives(const T *q, const T *v, const T *a, T *dtau)
///     void PREFIX_inverse_dynamics_jvp(const T *q, const T *v, const T *a, const T *dq, const T *dv, const T *da, T *dtau)
///     void PREFIX_inverse_dynamics_vjp(const T *q, const T *v, const T *a, const T *w, T *gradient)
///     void PREFIX_inverse_dynamics_hessian(const T *q, const T *v, const T *a, const T *w, T *hessian)
///     int  PREFIX_forward_dynamics_derivatives(const T *q, const T *v, const T *tau, T *da), ..._jvp, _vjp, _hessian
///
/// Derivatives by q, v and a or tau lie one behind the other, nv x nv or nv numbers each, and so do the blocks of a
/// Hessian, (q, q), (q, v), (v, v) and (a or tau, q). M and its inverse are nv x nv; C has 12 numbers for each frame, the
/// columns of R and then r; J is 6 x nv, row by row, angular before linear; in
/// another representation than body-fixed its function is PREFIX_jacobian_NAME_spatial and so on. Those of forward
/// dynamics and M_inverse return 0, or 1 where the mass matrix may be singular, and then the result is not to be trusted. Arrays must
/// not overlap. Armature and gravity are those of the model; joint losses and loads have no part in it. Results differ
/// from the library's by rounding, for angles up to 1e5 rad.
///
/// In CUDA states lie side by side: entry k of state i of n is x[k n + i]. Each function is there as a device function for a thread,
///
///     void PREFIX_inverse_dynamics(const T *q, const T *v, const T *a, T *tau, int n)
///
/// whose arguments point to the first entries of its state, and as a kernel for n states, a thread for each:
///
///     void PREFIX_inverse_dynamics_states(const T *q, const T *v, const T *a, T *tau, int n)
///
/// The kernel writes NaN where the function returns 1. Angles may have any size.
///
/// Time and memory are proportional to the operations: O(n), O(n²) for matrices, O(n² d) for the Hessian of forward
/// dynamics. Throws std::invalid_argument for a prefix that is no C identifier, a frame that there is not, no functions, and
/// one that is asked for twice.
Source c_source(const Model& model, std::span<const Function> functions, const Options& options = {});

}  // namespace axode::codegen
