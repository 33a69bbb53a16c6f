// The C interface of FMI 2.0: the functions that a master looks up by their names. See the standard for their
// arguments.
#include <algorithm>
#include <charconv>
#include <string_view>

#include "axode/fmi/binary/component.hpp"

using namespace axode::fmi;
using Reference = unsigned;
using Boolean = int;
using Mode = Instance::Mode;

namespace {

struct Callbacks {
  void (*log)(void* environment, const char* instance, Status status, const char* category,
              const char* format, ...);
  void* (*allocate)(std::size_t, std::size_t);
  void (*release)(void*);
  void (*step_finished)(void*, Status);
  void* environment;
};
struct EventInfo {
  Boolean discrete_states_needed, terminate, nominals_changed, states_changed, has_next;
  double next;
};

/// The path of a file URI such as file:///tmp/resources, with %-escapes decoded.
std::string path_of(std::string_view uri) {
  for (const std::string_view start : {"file://localhost", "file://", "file:"})
    if (uri.starts_with(start)) {
      uri.remove_prefix(start.size());
      break;
    }
  std::string path;
  for (std::size_t k = 0; k < uri.size(); ++k) {
    unsigned code = 0;
    const bool escape = uri[k] == '%' && k + 2 < uri.size() &&
                        std::from_chars(&uri[k + 1], &uri[k + 1] + 2, code, 16).ptr == &uri[k + 1] + 2;
    path += escape ? static_cast<char>(code) : uri[k];
    if (escape) k += 2;
  }
  return path;
}

}  // namespace

extern "C" {

const char* fmi2GetTypesPlatform() { return "default"; }
const char* fmi2GetVersion() { return "2.0"; }
Status fmi2SetDebugLogging(void*, Boolean, std::size_t, const char* const*) { return ok; }

void* fmi2Instantiate(const char* name, int kind, const char* token, const char* resources,
                      const Callbacks* callbacks, Boolean, Boolean) {
  const auto log = [callbacks, name = std::string(name == nullptr ? "" : name)](Status status,
                                                                                const char* text) {
    if (callbacks != nullptr && callbacks->log != nullptr)
      callbacks->log(callbacks->environment, name.c_str(), status, "logStatusError", "%s", text);
  };
  return make_component(kind == 0 ? Kind::model_exchange : Kind::co_simulation, token,
                        path_of(resources == nullptr ? "" : resources), log);
}
void fmi2FreeInstance(void* c) { free_component(c); }

Status fmi2SetupExperiment(void* c, Boolean has_tolerance, double tolerance, double start, Boolean, double) {
  return guarded(c, [&](Instance& its) {
    its.set_up(start, has_tolerance != 0 ? std::optional(tolerance) : std::nullopt);
  });
}
Status fmi2EnterInitializationMode(void* c) {
  return guarded(c, [](Instance& its) { its.enter(Mode::initialization); });
}
Status fmi2ExitInitializationMode(void* c) {
  return guarded(c, [](Instance& its) { its.exit_initialization(); });
}
Status fmi2Terminate(void* c) {
  return guarded(c, [](Instance& its) { its.enter(Mode::terminated); });
}
Status fmi2Reset(void* c) {
  return guarded(c, [](Instance& its) { its.reset(); });
}

Status fmi2GetReal(void* c, const Reference* r, std::size_t n, double* values) {
  return guarded(c, [&](Instance& its) { its.get({r, n}, {values, n}); });
}
Status fmi2SetReal(void* c, const Reference* r, std::size_t n, const double* values) {
  return guarded(c, [&](Instance& its) { its.set({r, n}, {values, n}); });
}
Status fmi2GetInteger(void* c, const Reference* r, std::size_t n, int*) { return no_variables(c, r, n); }
Status fmi2SetInteger(void* c, const Reference* r, std::size_t n, const int*) {
  return no_variables(c, r, n);
}
Status fmi2GetBoolean(void* c, const Reference* r, std::size_t n, Boolean*) { return no_variables(c, r, n); }
Status fmi2SetBoolean(void* c, const Reference* r, std::size_t n, const Boolean*) {
  return no_variables(c, r, n);
}
Status fmi2GetString(void* c, const Reference* r, std::size_t n, const char**) {
  return no_variables(c, r, n);
}
Status fmi2SetString(void* c, const Reference* r, std::size_t n, const char* const*) {
  return no_variables(c, r, n);
}

Status fmi2GetFMUstate(void* c, void** state) { return save(c, state); }
Status fmi2SetFMUstate(void* c, void* state) { return restore(c, state); }
Status fmi2FreeFMUstate(void*, void** state) { return free_state(state); }
Status fmi2SerializedFMUstateSize(void* c, void*, std::size_t*) {
  return unsupported(c, "fmi2SerializedFMUstateSize");
}
Status fmi2SerializeFMUstate(void* c, void*, char*, std::size_t) {
  return unsupported(c, "fmi2SerializeFMUstate");
}
Status fmi2DeSerializeFMUstate(void* c, const char*, std::size_t, void**) {
  return unsupported(c, "fmi2DeSerializeFMUstate");
}

Status fmi2GetDirectionalDerivative(void* c, const Reference* unknowns, std::size_t n_unknowns,
                                    const Reference* knowns, std::size_t n_knowns, const double* seed,
                                    double* result) {
  return guarded(c, [&](Instance& its) {
    its.directional_derivative({unknowns, n_unknowns}, {knowns, n_knowns}, {seed, n_knowns},
                               {result, n_unknowns});
  });
}

Status fmi2EnterEventMode(void* c) {
  return guarded(c, [](Instance& its) { its.enter(Mode::event); });
}
Status fmi2NewDiscreteStates(void* c, EventInfo* info) {
  return guarded(c, [&](Instance& its) {
    const Instance::Event event = its.update_discrete_states();
    *info = {0, 0, 0, event.states_changed, event.next.has_value(), event.next.value_or(0)};
  });
}
Status fmi2EnterContinuousTimeMode(void* c) {
  return guarded(c, [](Instance& its) { its.enter(Mode::continuous_time); });
}
Status fmi2CompletedIntegratorStep(void* c, Boolean, Boolean* enter_event_mode, Boolean* terminate) {
  return guarded(c, [&](Instance& its) {
    *terminate = 0;
    *enter_event_mode = its.needs_event();
  });
}
Status fmi2SetTime(void* c, double t) {
  return guarded(c, [&](Instance& its) { its.set_time(t); });
}
Status fmi2SetContinuousStates(void* c, const double* x, std::size_t n) {
  return guarded(c, [&](Instance& its) {
    check_count(n, its.n_states(), "continuous states");
    its.set_states({x, n});
  });
}
Status fmi2GetContinuousStates(void* c, double* x, std::size_t n) {
  return guarded(c, [&](Instance& its) {
    check_count(n, its.n_states(), "continuous states");
    its.get_states({x, n});
  });
}
Status fmi2GetDerivatives(void* c, double* dx, std::size_t n) {
  return guarded(c, [&](Instance& its) {
    check_count(n, its.n_states(), "continuous states");
    its.get_rates({dx, n});
  });
}
Status fmi2GetEventIndicators(void* c, double* z, std::size_t n) {
  return guarded(c, [&](Instance& its) {
    check_count(n, its.n_indicators(), "event indicators");
    its.get_indicators({z, n});
  });
}
Status fmi2GetNominalsOfContinuousStates(void* c, double* x, std::size_t n) {
  return guarded(c, [&](Instance& its) {
    check_count(n, its.n_states(), "continuous states");
    its.get_nominals({x, n});
  });
}

Status fmi2SetRealInputDerivatives(void* c, const Reference*, std::size_t n, const int*, const double*) {
  return n == 0 ? ok : unsupported(c, "fmi2SetRealInputDerivatives");
}
Status fmi2GetRealOutputDerivatives(void* c, const Reference*, std::size_t, const int*, double*) {
  return unsupported(c, "fmi2GetRealOutputDerivatives");
}
Status fmi2DoStep(void* c, double t, double h, Boolean) {
  return guarded(c, [&](Instance& its) { its.step(t, h); });
}
Status fmi2CancelStep(void* c) { return unsupported(c, "fmi2CancelStep"); }
Status fmi2GetStatus(void* c, int, Status*) { return unsupported(c, "fmi2GetStatus"); }
Status fmi2GetRealStatus(void* c, int, double*) { return unsupported(c, "fmi2GetRealStatus"); }
Status fmi2GetIntegerStatus(void* c, int, int*) { return unsupported(c, "fmi2GetIntegerStatus"); }
Status fmi2GetBooleanStatus(void* c, int, Boolean*) { return unsupported(c, "fmi2GetBooleanStatus"); }
Status fmi2GetStringStatus(void* c, int, const char**) { return unsupported(c, "fmi2GetStringStatus"); }

}  // extern "C"
