#pragma once
#include <span>
#include <string>

#include "axode/codegen/c_source.hpp"

namespace axode::codegen {

/// C source of external functions of CasADi, `casadi.external(NAME, LIBRARY)`, which needs no other file.
/// With the names of c_source, for each function
///
///     int NAME(const casadi_real **arg, casadi_real **res, casadi_int *iw, casadi_real *w, int mem)
///     casadi_int NAME_n_in(void), NAME_n_out(void); const char *NAME_name_in(casadi_int i), NAME_name_out(casadi_int i)
///     const casadi_int *NAME_sparsity_in(casadi_int i), *NAME_sparsity_out(casadi_int i)
///     int NAME_work(casadi_int *sz_arg, casadi_int *sz_res, casadi_int *sz_iw, casadi_int *sz_w)
///
/// and the same for its derivatives jac_NAME, fwd1_NAME, adj1_NAME and jac_adj1_NAME, the exact second
/// derivatives of what weights make of the results; M_inverse has none of second order. Matrices lie column
/// by column and have entries only where there is something; M and M_inverse are nv x nv, J is 6 x nv, a pose
/// 4 x 4. Derivatives by q are those by its nq entries, and quaternions count divided by their length.
/// Functions return 1 where the mass matrix may be singular. They keep nothing, so threads may call them at
/// once. Results may be null and are then not written, arguments may be null and are then 0.
///
/// With options.states = N functions are of N states at once, whose matrices stand side by side: q is nq x N.
/// To CasADi they are one operation with derivatives that are known block by block, where N calls are N
/// operations and many more for each derivative.
///
/// Throws std::invalid_argument for functions that are derivatives themselves, for a prefix that is no name
/// in CasADi (two underscores in a row, one at an end), and for single precision.
Source casadi_source(const Model& model, std::span<const Function> functions, const std::string& prefix,
                     const Options& options);

}  // namespace axode::codegen
