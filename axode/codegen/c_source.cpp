#include <algorithm>
#include <stdexcept>

#include "axode/codegen/c_function.hpp"
#include "axode/codegen/c_lanes.hpp"
#include "axode/codegen/c_names.hpp"
#include "axode/codegen/c_sine_cosine.hpp"
#include "axode/codegen/c_source.hpp"
#include "axode/codegen/casadi_source.hpp"
#include "axode/codegen/cuda_kernel.hpp"
#include "axode/codegen/states_source.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/model/check_no_loops.hpp"

namespace axode::codegen {
namespace {

/// The axes of the rows of a Jacobian.
const char* axes_of(Representation representation) {
  switch (representation) {
    case Representation::body: return "both in the axes of the frame, the linear one of its origin";
    case Representation::spatial:
      return "both in inertial axes, the linear one of the point that is at the inertial origin";
    case Representation::hybrid: return "both in inertial axes, the linear one of the frame's origin";
    case Representation::mixed: break;
  }
  return "the angular one in the axes of the frame, the linear one of its origin in inertial axes";
}

struct Part {
  Function function;
  std::string name;
  Recording recording;
};

std::string purpose(const Model& model, const Function& function) {
  const std::string nv = std::to_string(model.nv());
  switch (function.quantity) {
    case Quantity::inverse_dynamics:
      return "The drive forces tau (N m or N) that make the accelerations a at q, v.";
    case Quantity::forward_dynamics:
      return "The accelerations a that the drive forces tau (N m or N) make at q, v. Returns 0, or 1 where "
             "the\n"
             "   mass matrix may be singular; a is then not to be trusted.";
    case Quantity::mass_matrix:
      return "The mass matrix M (kg m^2, kg m, kg), " + nv + " x " + nv + ", row by row.";
    case Quantity::inverse_mass_matrix:
      return "The inverse of the mass matrix, " + nv + " x " + nv +
             ", row by row. Returns 0, or 1 where the mass matrix may be\n   singular; the result is then "
             "not to "
             "be trusted.";
    case Quantity::poses:
      return "The poses C of " + std::to_string(model.n_frames()) +
             " frames in the inertial frame, 12 numbers each: the columns of R, then r (m).";
    case Quantity::pose:
      return "The pose C of frame \"" + in_comment(model.frame(function.frame).name) +
             "\" in the inertial frame: the columns of R, then r (m).";
    case Quantity::inverse_dynamics_derivatives:
      return "The derivatives of tau by q, v and a, " + nv + " x " + nv +
             " each, one behind the other, row by row.";
    case Quantity::inverse_dynamics_jvp: return "What a direction (dq, dv, da) does to tau.";
    case Quantity::inverse_dynamics_vjp:
      return "The gradients of w tau by q, v and a, " + nv + " numbers each, one behind the other.";
    case Quantity::inverse_dynamics_hessian:
      return "The second derivatives of w tau by (q, q), (q, v), (v, v) and (a, q), " + nv + " x " + nv +
             " each, one\n   behind the other, row by row.";
    case Quantity::forward_dynamics_derivatives:
      return "The derivatives of a by q, v and tau, " + nv + " x " + nv +
             " each, one behind the other, row by row.\n   Returns what forward dynamics does.";
    case Quantity::forward_dynamics_jvp:
      return "What a direction (dq, dv, dtau) does to a. Returns what forward dynamics does.";
    case Quantity::forward_dynamics_vjp:
      return "The gradients of w a by q, v and tau, " + nv +
             " numbers each, one behind the other. Returns what\n   forward dynamics does.";
    case Quantity::forward_dynamics_hessian:
      return "The second derivatives of w a by (q, q), (q, v), (v, v) and (tau, q), " + nv + " x " + nv +
             " each, one\n   behind the other, row by row. Returns what forward dynamics does.";
    case Quantity::jacobian: break;
  }
  return "The Jacobian J of frame \"" + in_comment(model.frame(function.frame).name) + "\" in " +
         std::string(word_for(function.representation)) + " representation, 6 x " + nv +
         ", row by row: the angular\n   velocity (rad/s) and then the linear velocity (m/s) for a unit of "
         "each "
         "velocity,\n   " +
         axes_of(function.representation) + ".";
}

void check(const Model& model, std::span<const Function> functions, const std::string& prefix) {
  if (functions.empty()) throw std::invalid_argument("there are no functions to generate");
  for (const Function& function : functions) {
    if (is_of_a_frame(function.quantity)) check_place(model, function.frame);
    const std::string name = word_for(function.quantity);
    if (name.starts_with("forward_dynamics")) check_no_loops(model, "generated " + name);
  }
  if (!is_identifier(prefix))
    throw std::invalid_argument("the prefix \"" + prefix +
                                "\" is no C identifier: letters, digits and underscores, no digit first");
}

/// Six rows, one behind the other, become columns of six, as the library has them.
void by_columns(std::vector<Trace>& J) {
  const std::vector<Trace> rows = J;
  const std::size_t nv = rows.size() / 6;
  for (std::size_t k = 0; k < J.size(); ++k) J[k] = rows[k % 6 * nv + k / 6];
}

/// What there is besides the functions for one state.
struct Extras {
  bool many_states = false;
  int lanes = 1;
};

/// What the comment at the head of a file begins with.
std::string headline(const Model& model) {
  return "/* " + in_comment(model.name()) +
         ", generated by axode " AXODE_VERSION
         ".\n\n"
         "   Units are m, kg, s, rad. q has " +
         std::to_string(model.nq()) + " entries; v, a and tau have " + std::to_string(model.nv()) + ":\n\n" +
         coordinates(model) + "\n   Rotations are unit quaternions x y z w. Arrays must not overlap. ";
}

std::vector<Part> recorded(const Model& model, std::span<const Function> functions, const std::string& prefix,
                           bool single_precision) {
  const std::vector<std::string> names = function_names(model, functions, prefix, Abi::plain);
  std::vector<Part> parts;
  for (std::size_t k = 0; k < functions.size(); ++k)
    parts.push_back({functions[k], names[k], record(model, functions[k], single_precision)});
  return parts;
}

Source source_of(const Model& model, std::span<const Function> functions, const Options& options,
                 const Extras& extras) {
  const std::string prefix = options.prefix.empty() ? prefix_for(model, Abi::plain) : options.prefix;
  check(model, functions, prefix);
  const Precision precision{options.single_precision};
  std::vector<Part> parts = recorded(model, functions, prefix, options.single_precision);
  for (Part& part : parts)
    if (extras.many_states && part.function.quantity == Quantity::jacobian)
      by_columns(part.recording.results);

  Source source;
  std::string& text = source.text;
  text = headline(model) +
         "To be compiled without\n"
         "   -ffast-math, which breaks the sines; products and sums may become one instruction\n"
         "   (-ffp-contract=fast). */\n\n"
         "#ifdef __FAST_MATH__\n#error \"compile this file without -ffast-math\"\n#endif\n";
  const bool calls_math =
      std::ranges::any_of(parts, [](const Part& part) { return calls_math_library(part.recording); });
  if (calls_math || extras.many_states) text += "#include <math.h>\n";
  text +=
      "#ifdef __cplusplus\n#define AXODE_RESTRICT __restrict\nextern \"C\" {\n#else\n"
      "#define AXODE_RESTRICT restrict\n#endif\n\n";
  for (const Part& part : parts) {
    const Operations count = operations(part.recording);
    source.functions.push_back({part.name, count});
    text += "/* " + purpose(model, part.function) + "\n   " + counted(count) + ". */\n" +
            c_signature(part.recording, part.name, precision) + ";\n\n";
  }
  const std::string sine_cosine = prefix + "_sine_cosine";
  const bool turns = std::ranges::any_of(source.functions,
                                         [](const Source::Cost& cost) { return cost.operations.angles > 0; });
  if (turns)
    text += c_sine_cosine(sine_cosine, precision, extras.many_states ? Angles::all : Angles::moderate) + "\n";
  std::string definitions;
  bool is_cut = false;
  for (const Part& part : parts) {
    const Definition one = c_definition(part.recording, part.name, sine_cosine, precision);
    definitions += one.text + '\n';
    is_cut = is_cut || one.scratch > 0;
    if (!extras.many_states) continue;
    StatesFunction states{part.name, part.recording.lengths, static_cast<int>(part.recording.results.size()),
                          0, part.recording.returns_doubt};
    if (extras.lanes > 1) {
      const Definition in_lanes =
          c_definition(part.recording, part.name + "_lanes", sine_cosine, precision, Width::lanes);
      definitions += "#if AXODE_LANES > 1\n" + in_lanes.text + "#endif\n";
      states.scratch = in_lanes.scratch;
      is_cut = is_cut || in_lanes.scratch > 0;
    }
    definitions += c_states(states, precision, extras.lanes) + '\n';
  }
  if (is_cut)
    text +=
        "#ifdef __GNUC__\n#define AXODE_PART __attribute__((noinline))\n#else\n#define "
        "AXODE_PART\n#endif\n\n";
  if (extras.lanes > 1) text += c_lanes(precision, extras.lanes, calls_math);
  if (extras.lanes > 1 && turns) text += c_sine_cosine_in_lanes(sine_cosine, precision) + "\n";
  text += definitions;
  if (is_cut) text += "#undef AXODE_PART\n";
  text += "#undef AXODE_RESTRICT\n#ifdef __cplusplus\n}\n#endif\n";
  return source;
}

constexpr const char* cuda_head = R"(To be compiled without
   --use_fast_math, which spoils sines and roots; products and sums may become one instruction (--fmad).

   States lie side by side: entry k of state i of n is x[k * n + i], so that neighbouring threads read neighbouring
   numbers. Each function NAME is for one thread; its arguments point to the first entry of its state, x + i. The kernel
   NAME_states is for n states: start at least n threads, in blocks of at most 128. It writes NaN where NAME returns 1. */

#if defined(__USE_FAST_MATH__) && __USE_FAST_MATH__
#error "compile this file without --use_fast_math"
#endif
#define AXODE_RESTRICT __restrict__
#define AXODE_PART __device__ __noinline__

)";

Source cuda_source(const Model& model, std::span<const Function> functions, const Options& options) {
  const std::string prefix = options.prefix.empty() ? prefix_for(model, Abi::cuda) : options.prefix;
  check(model, functions, prefix);
  const Precision precision{options.single_precision};
  Source source;
  source.text = headline(model) + cuda_head +
                filled("enum { @P@_nq = @NQ@, @P@_nv = @NV@, @P@_n_frames = @NF@ };\n\n",
                       {{"P", prefix},
                        {"NQ", std::to_string(model.nq())},
                        {"NV", std::to_string(model.nv())},
                        {"NF", std::to_string(model.n_frames())}}) +
                cuda_entries;
  for (const Part& part : recorded(model, functions, prefix, options.single_precision)) {
    const Operations count = operations(part.recording);
    source.functions.push_back({part.name, count});
    source.text += "/* " + purpose(model, part.function) + "\n   " + counted(count) + ". */\n" +
                   c_definition(part.recording, part.name, "", precision, Width::thread).text +
                   cuda_kernel(part.recording, part.name, precision) + '\n';
  }
  source.text += "#undef AXODE_PART\n#undef AXODE_RESTRICT\n";
  return source;
}

}  // namespace

Source c_source(const Model& model, std::span<const Function> functions, const Options& options) {
  if (options.abi == Abi::casadi) {
    const std::string prefix = options.prefix.empty() ? prefix_for(model, Abi::casadi) : options.prefix;
    check(model, functions, prefix);
    return casadi_source(model, functions, prefix, options);
  }
  if (options.states != 1)
    throw std::invalid_argument("states is about functions for CasADi; others are of one state");
  return options.abi == Abi::cuda ? cuda_source(model, functions, options)
                                  : source_of(model, functions, options, {});
}

Source states_source(const Model& model, std::span<const Function> functions, bool single_precision,
                     int lanes) {
  return source_of(model, functions, {"axode", single_precision}, {.many_states = true, .lanes = lanes});
}

}  // namespace axode::codegen
