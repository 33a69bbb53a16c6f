// The C interface of FMI 3.0: the functions that a master looks up by their names. See the standard for their
// arguments.
#include <cstdint>

#include "axode/fmi/binary/component.hpp"

using namespace axode::fmi;
using Reference = unsigned;
using Mode = Instance::Mode;
using Log = void (*)(void* environment, Status status, const char* category, const char* message);

namespace {

void* instantiate(Kind kind, const char* token, const char* resources, void* environment, Log log) noexcept {
  return make_component(kind, token, resources == nullptr ? "" : resources,
                        [environment, log](Status status, const char* message) {
                          if (log != nullptr) log(environment, status, "logStatusError", message);
                        });
}

}  // namespace

extern "C" {

const char* fmi3GetVersion() { return "3.0"; }
Status fmi3SetDebugLogging(void*, bool, std::size_t, const char* const*) { return ok; }

void* fmi3InstantiateModelExchange(const char*, const char* token, const char* resources, bool, bool,
                                   void* environment, Log log) {
  return instantiate(Kind::model_exchange, token, resources, environment, log);
}
void* fmi3InstantiateCoSimulation(const char*, const char* token, const char* resources, bool, bool, bool,
                                  bool, const Reference*, std::size_t, void* environment, Log log, void*) {
  return instantiate(Kind::co_simulation, token, resources, environment, log);
}
void* fmi3InstantiateScheduledExecution(const char*, const char*, const char*, bool, bool, void*, Log, void*,
                                        void*, void*) {
  return nullptr;
}
void fmi3FreeInstance(void* c) { free_component(c); }

Status fmi3EnterInitializationMode(void* c, bool has_tolerance, double tolerance, double start, bool,
                                   double) {
  return guarded(c, [&](Instance& its) {
    its.enter_initialization(start, has_tolerance ? std::optional(tolerance) : std::nullopt);
  });
}
Status fmi3ExitInitializationMode(void* c) {
  return guarded(c, [](Instance& its) { its.exit_initialization(); });
}
Status fmi3EnterEventMode(void* c) {
  return guarded(c, [](Instance& its) { its.enter(Mode::event); });
}
Status fmi3EnterContinuousTimeMode(void* c) {
  return guarded(c, [](Instance& its) { its.enter(Mode::continuous_time); });
}
Status fmi3EnterStepMode(void* c) {
  return guarded(c, [](Instance& its) { its.enter(Mode::step); });
}
Status fmi3Terminate(void* c) {
  return guarded(c, [](Instance& its) { its.enter(Mode::terminated); });
}
Status fmi3Reset(void* c) {
  return guarded(c, [](Instance& its) { its.reset(); });
}

Status fmi3GetFloat64(void* c, const Reference* r, std::size_t n, double* values, std::size_t n_values) {
  return guarded(c, [&](Instance& its) {
    check_count(n_values, n, "values");
    its.get({r, n}, {values, n});
  });
}
Status fmi3SetFloat64(void* c, const Reference* r, std::size_t n, const double* values,
                      std::size_t n_values) {
  return guarded(c, [&](Instance& its) {
    check_count(n_values, n, "values");
    its.set({r, n}, {values, n});
  });
}

Status fmi3GetFloat32(void* c, const Reference* r, std::size_t n, float*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3SetFloat32(void* c, const Reference* r, std::size_t n, const float*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3GetInt8(void* c, const Reference* r, std::size_t n, std::int8_t*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3SetInt8(void* c, const Reference* r, std::size_t n, const std::int8_t*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3GetUInt8(void* c, const Reference* r, std::size_t n, std::uint8_t*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3SetUInt8(void* c, const Reference* r, std::size_t n, const std::uint8_t*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3GetInt16(void* c, const Reference* r, std::size_t n, std::int16_t*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3SetInt16(void* c, const Reference* r, std::size_t n, const std::int16_t*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3GetUInt16(void* c, const Reference* r, std::size_t n, std::uint16_t*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3SetUInt16(void* c, const Reference* r, std::size_t n, const std::uint16_t*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3GetInt32(void* c, const Reference* r, std::size_t n, std::int32_t*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3SetInt32(void* c, const Reference* r, std::size_t n, const std::int32_t*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3GetUInt32(void* c, const Reference* r, std::size_t n, std::uint32_t*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3SetUInt32(void* c, const Reference* r, std::size_t n, const std::uint32_t*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3GetInt64(void* c, const Reference* r, std::size_t n, std::int64_t*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3SetInt64(void* c, const Reference* r, std::size_t n, const std::int64_t*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3GetUInt64(void* c, const Reference* r, std::size_t n, std::uint64_t*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3SetUInt64(void* c, const Reference* r, std::size_t n, const std::uint64_t*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3GetBoolean(void* c, const Reference* r, std::size_t n, bool*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3SetBoolean(void* c, const Reference* r, std::size_t n, const bool*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3GetString(void* c, const Reference* r, std::size_t n, const char**, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3SetString(void* c, const Reference* r, std::size_t n, const char* const*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3GetBinary(void* c, const Reference* r, std::size_t n, std::size_t*, const std::uint8_t**,
                     std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3SetBinary(void* c, const Reference* r, std::size_t n, const std::size_t*,
                     const std::uint8_t* const*, std::size_t) {
  return no_variables(c, r, n);
}
Status fmi3GetClock(void* c, const Reference* r, std::size_t n, bool*) { return no_variables(c, r, n); }
Status fmi3SetClock(void* c, const Reference* r, std::size_t n, const bool*) { return no_variables(c, r, n); }

Status fmi3GetFMUState(void* c, void** state) { return save(c, state); }
Status fmi3SetFMUState(void* c, void* state) { return restore(c, state); }
Status fmi3FreeFMUState(void*, void** state) { return free_state(state); }
Status fmi3SerializedFMUStateSize(void* c, void*, std::size_t*) {
  return unsupported(c, "fmi3SerializedFMUStateSize");
}
Status fmi3SerializeFMUState(void* c, void*, std::uint8_t*, std::size_t) {
  return unsupported(c, "fmi3SerializeFMUState");
}
Status fmi3DeserializeFMUState(void* c, const std::uint8_t*, std::size_t, void**) {
  return unsupported(c, "fmi3DeserializeFMUState");
}

Status fmi3GetDirectionalDerivative(void* c, const Reference* unknowns, std::size_t n_unknowns,
                                    const Reference* knowns, std::size_t n_knowns, const double* seed,
                                    std::size_t n_seed, double* result, std::size_t n_result) {
  return guarded(c, [&](Instance& its) {
    check_count(n_seed, n_knowns, "numbers of the seed");
    check_count(n_result, n_unknowns, "results");
    its.directional_derivative({unknowns, n_unknowns}, {knowns, n_knowns}, {seed, n_seed},
                               {result, n_result});
  });
}
Status fmi3GetAdjointDerivative(void* c, const Reference* unknowns, std::size_t n_unknowns,
                                const Reference* knowns, std::size_t n_knowns, const double* seed,
                                std::size_t n_seed, double* result, std::size_t n_result) {
  return guarded(c, [&](Instance& its) {
    check_count(n_seed, n_unknowns, "numbers of the seed");
    check_count(n_result, n_knowns, "results");
    its.adjoint_derivative({unknowns, n_unknowns}, {knowns, n_knowns}, {seed, n_seed}, {result, n_result});
  });
}

Status fmi3UpdateDiscreteStates(void* c, bool* again, bool* terminate, bool* nominals_changed,
                                bool* states_changed, bool* has_next, double* next) {
  return guarded(c, [&](Instance& its) {
    const Instance::Event event = its.update_discrete_states();
    *again = *terminate = *nominals_changed = false;
    *states_changed = event.states_changed;
    *has_next = event.next.has_value();
    *next = event.next.value_or(0);
  });
}
Status fmi3EvaluateDiscreteStates(void*) { return ok; }
Status fmi3CompletedIntegratorStep(void* c, bool, bool* enter_event_mode, bool* terminate) {
  return guarded(c, [&](Instance& its) {
    *terminate = false;
    *enter_event_mode = its.needs_event();
  });
}
Status fmi3SetTime(void* c, double t) {
  return guarded(c, [&](Instance& its) { its.set_time(t); });
}
Status fmi3SetContinuousStates(void* c, const double* x, std::size_t n) {
  return guarded(c, [&](Instance& its) {
    check_count(n, its.n_states(), "continuous states");
    its.set_states({x, n});
  });
}
Status fmi3GetContinuousStates(void* c, double* x, std::size_t n) {
  return guarded(c, [&](Instance& its) {
    check_count(n, its.n_states(), "continuous states");
    its.get_states({x, n});
  });
}
Status fmi3GetContinuousStateDerivatives(void* c, double* dx, std::size_t n) {
  return guarded(c, [&](Instance& its) {
    check_count(n, its.n_states(), "continuous states");
    its.get_rates({dx, n});
  });
}
Status fmi3GetEventIndicators(void* c, double* z, std::size_t n) {
  return guarded(c, [&](Instance& its) {
    check_count(n, its.n_indicators(), "event indicators");
    its.get_indicators({z, n});
  });
}
Status fmi3GetNominalsOfContinuousStates(void* c, double* x, std::size_t n) {
  return guarded(c, [&](Instance& its) {
    check_count(n, its.n_states(), "continuous states");
    its.get_nominals({x, n});
  });
}
Status fmi3GetNumberOfEventIndicators(void* c, std::size_t* n) {
  return guarded(c, [&](Instance& its) { *n = its.n_indicators(); });
}
Status fmi3GetNumberOfContinuousStates(void* c, std::size_t* n) {
  return guarded(c, [&](Instance& its) { *n = its.n_states(); });
}

Status fmi3DoStep(void* c, double t, double h, bool, bool* event_needed, bool* terminate, bool* early_return,
                  double* last_time) {
  return guarded(c, [&](Instance& its) {
    *event_needed = *terminate = *early_return = false;
    *last_time = t;
    its.step(t, h);
    *last_time = t + h;
  });
}

Status fmi3GetNumberOfVariableDependencies(void* c, Reference, std::size_t*) {
  return unsupported(c, "fmi3GetNumberOfVariableDependencies");
}
Status fmi3GetVariableDependencies(void* c, Reference, std::size_t*, Reference*, std::size_t*, int*,
                                   std::size_t) {
  return unsupported(c, "fmi3GetVariableDependencies");
}
Status fmi3EnterConfigurationMode(void* c) { return unsupported(c, "fmi3EnterConfigurationMode"); }
Status fmi3ExitConfigurationMode(void* c) { return unsupported(c, "fmi3ExitConfigurationMode"); }
Status fmi3GetIntervalDecimal(void* c, const Reference* r, std::size_t n, double*, int*) {
  return no_variables(c, r, n);
}
Status fmi3GetIntervalFraction(void* c, const Reference* r, std::size_t n, std::uint64_t*, std::uint64_t*,
                               int*) {
  return no_variables(c, r, n);
}
Status fmi3GetShiftDecimal(void* c, const Reference* r, std::size_t n, double*) {
  return no_variables(c, r, n);
}
Status fmi3GetShiftFraction(void* c, const Reference* r, std::size_t n, std::uint64_t*, std::uint64_t*) {
  return no_variables(c, r, n);
}
Status fmi3SetIntervalDecimal(void* c, const Reference* r, std::size_t n, const double*) {
  return no_variables(c, r, n);
}
Status fmi3SetIntervalFraction(void* c, const Reference* r, std::size_t n, const std::uint64_t*,
                               const std::uint64_t*) {
  return no_variables(c, r, n);
}
Status fmi3SetShiftDecimal(void* c, const Reference* r, std::size_t n, const double*) {
  return no_variables(c, r, n);
}
Status fmi3SetShiftFraction(void* c, const Reference* r, std::size_t n, const std::uint64_t*,
                            const std::uint64_t*) {
  return no_variables(c, r, n);
}
Status fmi3GetOutputDerivatives(void* c, const Reference*, std::size_t, const std::int32_t*, double*,
                                std::size_t) {
  return unsupported(c, "fmi3GetOutputDerivatives");
}
Status fmi3ActivateModelPartition(void* c, Reference, double) {
  return unsupported(c, "fmi3ActivateModelPartition");
}

}  // extern "C"
