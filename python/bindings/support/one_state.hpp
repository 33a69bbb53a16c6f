#pragma once
#include "python/bindings/states/states.hpp"

namespace axode::python {

/// The state in an argument of a function of one state. Throws nb::value_error for any other shape.
inline States one_state(const BoundModel& model, ArrayLike q, const char* name = "q") {
  const Numbers numbers(name, q);
  const Shape expected{model->nq()};
  if (numbers.axes() != 1 || !numbers.ends_with(expected))
    numbers.wrong_shape(expected.text() + ", one state with nq = " + std::to_string(model->nq()) +
                        " coordinates");
  return {model, q, 1, name};
}

}  // namespace axode::python
