#pragma once
#include <span>
#include <string>

#include "axode/codegen/c/c_source.hpp"

namespace axode::codegen {

/// C source of external functions of CasADi, which are loaded by `casadi.external(NAME, LIBRARY)`. The source
/// needs no other file. NAME is made of options.prefix or the model's name, and the name of the function. For
/// each function there are
///
///     int NAME(const casadi_real **arg, casadi_real **res, casadi_int *iw, casadi_real *w, int mem)
///     casadi_int NAME_n_in(void), NAME_n_out(void)
///     const char *NAME_name_in(casadi_int i), *NAME_name_out(casadi_int i)
///     const casadi_int *NAME_sparsity_in(casadi_int i), *NAME_sparsity_out(casadi_int i)
///     int NAME_work(casadi_int *sz_arg, casadi_int *sz_res, casadi_int *sz_iw, casadi_int *sz_w)
///
/// and functions with equal signatures for its derivatives: fwd1_NAME along a direction, adj1_NAME, the
/// gradient of the weighted sum of the results, the Jacobian jac_NAME, and the Jacobian jac_adj1_NAME of
/// adj1_NAME. The inverse mass matrix has no jac_adj1_NAME. Matrices are sparse and stored column by column;
/// the mass matrix and its inverse are nv x nv, the Jacobian of a frame is 6 x nv, a pose is 4 x 4.
/// Derivatives by q are derivatives by its nq entries, and quaternions are divided by their norm. Functions
/// return 1 if the mass matrix may be singular, otherwise 0. Several threads may call them at once. Results
/// that are null are not written, and arguments that are null count as 0.
///
/// If options.states = N, a function takes N states at once, whose matrices stand side by side: q is nq x N.
/// For CasADi this is one operation instead of N, with block diagonal Jacobians.
///
/// Throws std::invalid_argument for a function that is itself a derivative, for a prefix that is not a name
/// in CasADi (two underscores in a row, or one at an end), for options.states < 1 or so large that an index
/// does not fit into an int, and for single precision.
Source casadi_source(const Model& model, std::span<const Function> functions, const std::string& prefix,
                     const Options& options);

}  // namespace axode::codegen
